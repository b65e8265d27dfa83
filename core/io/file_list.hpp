// From the inputs a person names (files and folders) to the list of files to read, in order.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/base/status.hpp"

namespace planecast {

/// Expands inputs in the order given. A file stands for itself, whatever its kind. A folder stands
/// for its readable files (not those of folders inside), in natural order; hidden files do not
/// count, and text files only when there is no other kind (they are notes beside the frames).
/// `ignored`, when given, receives the files of folders that were left out, for a note to the user.
/// Inputs that are no paths ("sim:room", "lcm:NAME") must be taken out before.
/// Errors: kUsage without inputs; kNotFound, with the nearest name that exists; kUnreadable for a
/// folder with nothing readable or with several kinds of frames, naming them.
Result<std::vector<std::filesystem::path>> expand_inputs(
    std::span<const std::string> inputs, std::vector<std::filesystem::path>* ignored = nullptr);

}  // namespace planecast
