#include "tests/golden/golden_files.hpp"

#include <fstream>

#include "core/base/bytes.hpp"

namespace planecast::test {

Result<Bytes> read_golden_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return Error{Status::kNotFound, path.string() + " cannot be read"};
  Bytes bytes(static_cast<std::size_t>(file.tellg()));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file) return Error{Status::kNotFound, path.string() + " cannot be read to its end"};
  return bytes;
}

Result<Done> write_golden_file(const std::filesystem::path& path,
                               std::span<const std::uint8_t> bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) return Error{Status::kWriteFailed, path.string() + " cannot be written"};
  return Done{};
}

Result<Done> write_golden_file(const std::filesystem::path& path, std::string_view text) {
  return write_golden_file(
      path, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

Result<std::vector<std::uint16_t>> read_counts(const std::filesystem::path& path,
                                               std::size_t pixels) {
  const auto bytes = read_golden_file(path);
  if (!bytes.ok()) return bytes.error();
  if (bytes->size() != 2 * pixels)
    return Error{Status::kUnreadable, path.string() + " has another size"};
  std::vector<std::uint16_t> out(pixels);
  for (std::size_t i = 0; i < pixels; ++i) out[i] = load_le<std::uint16_t>(&(*bytes)[2 * i]);
  return out;
}

}  // namespace planecast::test
