#include "core/io/pcd_data.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "core/base/bytes.hpp"
#include "core/io/file_bytes.hpp"
#include "core/io/io_error.hpp"
#include "core/io/lzf.hpp"
#include "core/io/text.hpp"

namespace planecast {
namespace {

namespace fs = std::filesystem;

// Where one axis lies in a block of memory: point i starts at first + i * stride.
struct Axis {
  std::size_t first;
  std::size_t stride;
  bool wide;
};

double load_axis(const std::uint8_t* data, const Axis& axis, std::size_t i) noexcept {
  const std::uint8_t* const at = data + axis.first + i * axis.stride;
  if (axis.wide) return std::bit_cast<double>(load_le<std::uint64_t>(at));
  return std::bit_cast<float>(load_le<std::uint32_t>(at));
}

// Binary data hold point after point; compressed data hold field after field.
std::vector<Point3d> gather(const PcdHeader& header, const std::uint8_t* data, bool by_field) {
  std::array<Axis, 3> axes{};
  for (std::size_t a = 0; a < 3; ++a) {
    const PcdField& field = header.fields[header.xyz[a]];
    axes[a] = by_field ? Axis{field.offset * header.points, field.size, field.size == 8}
                       : Axis{field.offset, header.point_bytes, field.size == 8};
  }
  std::vector<Point3d> points(header.points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = {load_axis(data, axes[0], i), load_axis(data, axes[1], i),
                 load_axis(data, axes[2], i)};
  }
  return points;
}

bool all_zero(std::span<const std::uint8_t> bytes) noexcept {
  return std::all_of(bytes.begin(), bytes.end(), [](std::uint8_t b) { return b == 0; });
}

Error left_over(const fs::path& path, std::size_t offset, std::size_t bytes) {
  return file_error(path, at_byte(offset), std::to_string(bytes) + " bytes are left after the data",
                    "WIDTH, HEIGHT and POINTS may be too small: correct them");
}

Error too_short(const fs::path& path, std::size_t size, std::uint64_t needed) {
  return file_error(path, at_byte(size),
                    "the file ends, the header promises data up to byte " + std::to_string(needed),
                    kCutShort);
}

Result<std::vector<Point3d>> read_binary(const fs::path& path, const PcdHeader& header,
                                         std::span<const std::uint8_t> file) {
  const auto data = file.subspan(header.data_offset);
  if (data.size() < header.data_bytes()) {
    return too_short(path, file.size(), header.data_offset + header.data_bytes());
  }
  const auto rest = data.subspan(header.points * header.point_bytes);
  if (!all_zero(rest)) return left_over(path, file.size() - rest.size(), rest.size());
  return gather(header, data.data(), false);
}

Result<std::vector<Point3d>> read_compressed(const fs::path& path, const PcdHeader& header,
                                             std::span<const std::uint8_t> file) {
  constexpr std::size_t kSizesBytes = 8;
  const std::size_t start = header.data_offset;
  if (header.points == 0 && all_zero(file.subspan(start))) return std::vector<Point3d>();
  if (file.size() - start < kSizesBytes) return too_short(path, file.size(), start + kSizesBytes);
  const std::size_t packed = load_le<std::uint32_t>(file.data() + start);
  const std::size_t expanded = load_le<std::uint32_t>(file.data() + start + 4);
  if (expanded != header.data_bytes()) {
    return file_error(path, at_byte(start + 4),
                      "the data expand to " + std::to_string(expanded) +
                          " bytes, the header asks for " + std::to_string(header.data_bytes()),
                      "correct WIDTH, HEIGHT, POINTS, SIZE or COUNT");
  }
  const auto data = file.subspan(start + kSizesBytes);
  if (data.size() < packed) {
    return too_short(path, file.size(), std::uint64_t{start} + kSizesBytes + packed);
  }
  if (expanded > kMaxFileBytes || expanded > packed * kMaxLzfExpansion) {
    return file_error(
        path, at_byte(start),
        std::to_string(packed) + " packed bytes cannot expand to " + std::to_string(expanded),
        kCutShort);
  }
  const auto rest = data.subspan(packed);
  if (!all_zero(rest)) return left_over(path, file.size() - rest.size(), rest.size());
  std::vector<std::uint8_t> fields(expanded);
  std::size_t stopped_at = 0;
  const Status status = lzf_expand(data.first(packed), fields, stopped_at);
  if (status != Status::kOk) {
    return file_error(path, at_byte(start + kSizesBytes + stopped_at),
                      "the compressed data are corrupt (" + std::string(to_string(status)) + ")",
                      "get the file anew");
  }
  return gather(header, fields.data(), true);
}

class AsciiReader {
 public:
  AsciiReader(const fs::path& path, const PcdHeader& header, std::string_view text)
      : path_(path), header_(header), text_(text) {}

  Result<std::vector<Point3d>> read();

 private:
  bool take_line(std::size_t line);
  bool fail(std::size_t line, std::string_view what, std::string_view mend) {
    error_ = file_error(path_, at_line(line), what, mend);
    return false;
  }

  const fs::path& path_;
  const PcdHeader& header_;
  std::string_view text_;
  std::vector<std::string_view> words_;
  std::vector<Point3d> points_;
  Error error_;
};

bool AsciiReader::take_line(std::size_t line) {
  if (points_.size() == header_.points) {
    return fail(line, "there are more points than POINTS " + std::to_string(header_.points),
                "correct WIDTH, HEIGHT and POINTS");
  }
  if (words_.size() != header_.point_words) {
    return fail(line,
                "there are " + std::to_string(words_.size()) + " values, the header asks for " +
                    std::to_string(header_.point_words),
                "correct the line, or FIELDS and COUNT");
  }
  std::array<double, 3> v{};
  for (std::size_t a = 0; a < 3; ++a) {
    const std::string_view word = words_[header_.fields[header_.xyz[a]].word];
    const auto value = parse_number(word);
    if (!value) return fail(line, in_quotes(word) + " is not a number", "correct the line");
    v[a] = *value;
  }
  points_.push_back({v[0], v[1], v[2]});
  return true;
}

Result<std::vector<Point3d>> AsciiReader::read() {
  // A value takes at least a digit and a separator; the last one may lack the separator.
  if (text_.size() + 1 < std::uint64_t{header_.points} * header_.point_words * 2) {
    return file_error(path_, at_line(header_.data_line),
                      "the data are too short for POINTS " + std::to_string(header_.points),
                      kCutShort);
  }
  points_.reserve(header_.points);
  LineReader reader(text_, header_.data_line);
  std::string_view line;
  while (reader.next(line)) {
    split_words(line, words_);
    if (!words_.empty() && !take_line(reader.line())) return error_;
  }
  if (points_.size() != header_.points) {
    return file_error(path_, at_line(reader.line()),
                      "the file ends after " + std::to_string(points_.size()) +
                          " points, the header promises " + std::to_string(header_.points),
                      kCutShort);
  }
  return std::move(points_);
}

}  // namespace

Result<std::vector<Point3d>> read_pcd_points(const fs::path& path, const PcdHeader& header,
                                             std::span<const std::uint8_t> file) {
  switch (header.encoding) {
    case PcdEncoding::kBinary:
      return read_binary(path, header, file);
    case PcdEncoding::kBinaryCompressed:
      return read_compressed(path, header, file);
    case PcdEncoding::kAscii:
      break;
  }
  return AsciiReader(path, header, as_text(file).substr(header.data_offset)).read();
}

}  // namespace planecast
