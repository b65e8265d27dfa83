#include "core/io/file_bytes.hpp"

#include <cerrno>
#include <fstream>
#include <system_error>

#include "core/io/io_error.hpp"

namespace planecast {
namespace {

namespace fs = std::filesystem;

std::string system_reason(int code) {
  return std::generic_category().message(code);
}

Result<std::size_t> checked_size(const fs::path& path) {
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (status.type() == fs::file_type::not_found) {
    return file_error(path, "", "no such file", "check the path", Status::kNotFound);
  }
  if (status.type() == fs::file_type::directory) {
    return file_error(path, "", "is a folder", "name a file in it");
  }
  if (code || status.type() != fs::file_type::regular) {
    return file_error(path, "", "is not a regular file", "copy its content into a file first");
  }
  const std::uint64_t size = fs::file_size(path, code);
  if (code) return file_error(path, "", code.message(), "check the permissions");
  if (size > kMaxFileBytes) {
    return file_error(path, "",
                      "has " + std::to_string(size) + " bytes, more than the limit of " +
                          std::to_string(kMaxFileBytes),
                      "split it into smaller files");
  }
  return static_cast<std::size_t>(size);
}

}  // namespace

Result<std::vector<std::uint8_t>> read_file_bytes(const fs::path& path) {
  const Result<std::size_t> size = checked_size(path);
  if (!size) return size.error();
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) return file_error(path, "", system_reason(errno), "check the permissions");
  std::vector<std::uint8_t> bytes(*size);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  const auto got = static_cast<std::uint64_t>(file.gcount());
  if (got != *size) {
    return file_error(path, at_byte(got), "reading stopped before the end of the file",
                      "check the disk, and that no program is still writing the file");
  }
  return bytes;
}

Result<Done> write_file_bytes(const fs::path& path, std::span<const std::uint8_t> bytes) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (file) {
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    file.close();
  }
  if (!file) {
    const std::string reason = errno != 0 ? system_reason(errno) : "unknown reason";
    return file_error(path, "", "cannot be written (" + reason + ")",
                      "check that its folder exists, is writable and has room",
                      Status::kWriteFailed);
  }
  return Done{};
}

Result<Done> write_file_text(const fs::path& path, std::string_view text) {
  return write_file_bytes(path, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace planecast
