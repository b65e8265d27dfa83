#include "core/io/ply_data.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/base/bytes.hpp"
#include "core/io/file_bytes.hpp"
#include "core/io/io_error.hpp"
#include "core/io/text.hpp"

namespace planecast {
namespace {

namespace fs = std::filesystem;

// Takes value after value from a binary body. Both cursors share the interface that PlyWalker uses.
class BinaryCursor {
 public:
  BinaryCursor(std::span<const std::uint8_t> file, std::size_t offset, bool big_endian)
      : file_(file), offset_(offset), big_endian_(big_endian) {}

  bool read(PlyType type, double& value) noexcept {
    const std::size_t bytes = ply_type_bytes(type);
    if (remaining() < bytes) return false;
    value = load(type, file_.data() + offset_);
    offset_ += bytes;
    return true;
  }

  bool skip(PlyType type, std::size_t count) noexcept {
    // Divided, not multiplied: count comes from the file.
    if (count > remaining() / ply_type_bytes(type)) return false;
    offset_ += count * ply_type_bytes(type);
    return true;
  }

  std::uint64_t min_bytes(PlyType type) const noexcept { return ply_type_bytes(type); }
  std::uint64_t remaining() const noexcept { return file_.size() - offset_; }
  std::string place() const { return at_byte(offset_); }

  // Some writers end the file with a line end or zero padding; anything else is content not read.
  bool at_end() const noexcept {
    const auto rest = file_.subspan(offset_);
    return std::all_of(rest.begin(), rest.end(),
                       [](std::uint8_t b) { return b == 0 || is_space(static_cast<char>(b)); });
  }

 private:
  template <class T>
  T load_as(const std::uint8_t* at) const noexcept {
    return big_endian_ ? load_be<T>(at) : load_le<T>(at);
  }

  double load(PlyType type, const std::uint8_t* at) const noexcept {
    switch (type) {
      case PlyType::kI8:
        return static_cast<std::int8_t>(*at);
      case PlyType::kU8:
        return *at;
      case PlyType::kI16:
        return static_cast<std::int16_t>(load_as<std::uint16_t>(at));
      case PlyType::kU16:
        return load_as<std::uint16_t>(at);
      case PlyType::kI32:
        return static_cast<std::int32_t>(load_as<std::uint32_t>(at));
      case PlyType::kU32:
        return load_as<std::uint32_t>(at);
      case PlyType::kF32:
        return std::bit_cast<float>(load_as<std::uint32_t>(at));
      case PlyType::kF64:
        break;
    }
    return std::bit_cast<double>(load_as<std::uint64_t>(at));
  }

  std::span<const std::uint8_t> file_;
  std::size_t offset_;
  bool big_endian_;
};

// Takes word after word from an ascii body; line ends are space, as in most other readers.
class AsciiCursor {
 public:
  AsciiCursor(std::string_view text, std::size_t line) : text_(text), line_(line) {}

  bool read(PlyType, double& value) noexcept {
    skip_space();
    const std::size_t start = at_;
    while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
    const auto number = parse_number(text_.substr(start, at_ - start));
    if (number) value = *number;
    return number.has_value();
  }

  bool skip(PlyType type, std::size_t count) noexcept {
    double ignored = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (!read(type, ignored)) return false;
    }
    return true;
  }

  std::uint64_t min_bytes(PlyType) const noexcept { return 2; }
  // One more than there are: the last word needs no space after it.
  std::uint64_t remaining() const noexcept { return text_.size() - at_ + 1; }
  std::string place() const { return at_line(line_); }

  bool at_end() noexcept {
    skip_space();
    return at_ == text_.size();
  }

 private:
  void skip_space() noexcept {
    for (; at_ < text_.size() && is_space(text_[at_]); ++at_) {
      if (text_[at_] == '\n') ++line_;
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_;
};

template <class Cursor>
class PlyWalker {
 public:
  PlyWalker(const fs::path& path, const PlyHeader& header, Cursor cursor)
      : path_(path), header_(header), cursor_(cursor) {}

  Result<std::vector<Point3d>> walk() {
    for (std::size_t i = 0; i < header_.elements.size(); ++i) {
      if (!walk_element(header_.elements[i], i == header_.vertex)) return error_;
    }
    if (!cursor_.at_end()) {
      fail("there are data after the last element", "a count in the header may be too small");
      return error_;
    }
    return std::move(points_);
  }

 private:
  bool fail(std::string_view what, std::string_view mend) {
    error_ = file_error(path_, cursor_.place(), what, mend);
    return false;
  }

  bool walk_element(const PlyElement& element, bool is_vertex) {
    std::uint64_t least = 0;
    for (const PlyProperty& p : element.properties) {
      least += cursor_.min_bytes(p.is_list ? p.count_type : p.type);
    }
    if (least == 0) return true;  // no properties, no bytes: whatever the count claims
    if (element.count > cursor_.remaining() / least) {
      return fail("the file is too short for element " + in_quotes(element.name) + " " +
                      std::to_string(element.count),
                  kCutShort);
    }
    const auto count = static_cast<std::size_t>(element.count);  // not more than the file has bytes
    if (is_vertex) points_.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      Point3d point;
      if (!walk_item(element, point)) return false;
      if (is_vertex) points_.push_back(point);
    }
    return true;
  }

  bool walk_item(const PlyElement& element, Point3d& point) {
    for (const PlyProperty& property : element.properties) {
      if (property.is_list ? !skip_list(property) : !read_value(property, point)) return false;
    }
    return true;
  }

  bool read_value(const PlyProperty& property, Point3d& point) {
    double value = 0;
    if (!cursor_.read(property.type, value)) {
      return fail("no number for property " + in_quotes(property.name), kCutShort);
    }
    if (property.name == "x") point.x = value;
    if (property.name == "y") point.y = value;
    if (property.name == "z") point.z = value;
    return true;
  }

  bool skip_list(const PlyProperty& property) {
    double length = 0;
    const bool good = cursor_.read(property.count_type, length) && length >= 0 &&
                      length <= std::numeric_limits<std::uint32_t>::max() &&
                      length == std::floor(length);
    if (!good || !cursor_.skip(property.type, static_cast<std::size_t>(length))) {
      return fail("list " + in_quotes(property.name) + " has a wrong length or ends too early",
                  kCutShort);
    }
    return true;
  }

  const fs::path& path_;
  const PlyHeader& header_;
  Cursor cursor_;
  std::vector<Point3d> points_;
  Error error_;
};

}  // namespace

Result<std::vector<Point3d>> read_ply_points(const fs::path& path, const PlyHeader& header,
                                             std::span<const std::uint8_t> file) {
  if (header.encoding == PlyEncoding::kAscii) {
    const std::string_view text = as_text(file).substr(header.data_offset);
    return PlyWalker(path, header, AsciiCursor(text, header.data_line)).walk();
  }
  const bool big_endian = header.encoding == PlyEncoding::kBigEndian;
  return PlyWalker(path, header, BinaryCursor(file, header.data_offset, big_endian)).walk();
}

}  // namespace planecast
