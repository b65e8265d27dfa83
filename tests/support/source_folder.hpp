// Where the sources lie, for tests that read files of the repository.
#pragma once

#include <filesystem>

namespace planecast::test {

std::filesystem::path source_folder();

}  // namespace planecast::test
