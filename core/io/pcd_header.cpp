#include "core/io/pcd_header.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/io/file_bytes.hpp"
#include "core/io/io_error.hpp"
#include "core/io/text.hpp"

namespace planecast {
namespace {

constexpr std::uint64_t kMaxPointBytes = 1U << 20U;
constexpr std::array<std::string_view, 10> kKeywords = {
    "VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "POINTS", "DATA", "VIEWPOINT"};

class PcdHeaderParser {
 public:
  PcdHeaderParser(const std::filesystem::path& path, std::span<const std::uint8_t> file)
      : path_(path), file_(file) {}

  Result<PcdHeader> parse();

 private:
  // A failed step sets error_ and returns false, so that steps chain with &&.
  bool fail(std::string_view what, std::string_view mend);
  bool fail_header(std::string_view what, std::string_view mend);
  bool take_line(std::string_view keyword);
  bool take_version();
  bool take_fields();
  bool take_types();
  bool take_counts(std::string_view keyword, std::vector<std::uint32_t>& counts);
  bool take_size(std::optional<std::uint64_t>& value);
  bool take_viewpoint();
  bool take_data();
  bool finish();
  bool finish_layout();
  bool finish_shape();
  bool find_axis(std::size_t axis);
  bool check_list(std::string_view keyword, std::size_t entries);

  const std::filesystem::path& path_;
  std::span<const std::uint8_t> file_;
  std::size_t line_ = 0;
  std::vector<std::string_view> words_;
  std::vector<std::string_view> seen_;
  std::vector<char> types_;
  std::vector<std::uint32_t> sizes_;
  std::vector<std::uint32_t> counts_;
  std::optional<std::uint64_t> width_;
  std::optional<std::uint64_t> height_;
  std::optional<std::uint64_t> points_;
  PcdHeader header_;
  Error error_;
};

bool PcdHeaderParser::fail(std::string_view what, std::string_view mend) {
  error_ = file_error(path_, at_line(line_), what, mend);
  return false;
}

bool PcdHeaderParser::fail_header(std::string_view what, std::string_view mend) {
  error_ = file_error(path_, "header", what, mend);
  return false;
}

bool PcdHeaderParser::take_version() {
  const std::string_view v = words_.size() == 2 ? words_[1] : std::string_view();
  for (const std::string_view known : {".5", "0.5", ".6", "0.6", ".7", "0.7"}) {
    if (v == known) return true;
  }
  return fail("PCD version " + in_quotes(v) + " is not known", "write the file as version 0.7");
}

bool PcdHeaderParser::take_fields() {
  for (std::size_t i = 1; i < words_.size(); ++i) {
    PcdField field;
    field.name = words_[i];
    header_.fields.push_back(std::move(field));
  }
  return !header_.fields.empty() || fail("no fields are named", "write FIELDS x y z");
}

bool PcdHeaderParser::take_types() {
  for (std::size_t i = 1; i < words_.size(); ++i) {
    const std::string_view t = words_[i];
    if (t != "F" && t != "I" && t != "U") {
      return fail("TYPE " + in_quotes(t) + " is not known", "types are F, I and U");
    }
    types_.push_back(t[0]);
  }
  return true;
}

bool PcdHeaderParser::take_counts(std::string_view keyword, std::vector<std::uint32_t>& counts) {
  for (std::size_t i = 1; i < words_.size(); ++i) {
    const auto value = parse_count(words_[i]);
    if (!value || *value == 0 || *value > kMaxPointBytes) {
      return fail(std::string(keyword) + " " + in_quotes(words_[i]) + " is out of range",
                  "it must be a whole number from 1 to " + std::to_string(kMaxPointBytes));
    }
    counts.push_back(static_cast<std::uint32_t>(*value));
  }
  return true;
}

bool PcdHeaderParser::take_size(std::optional<std::uint64_t>& value) {
  const std::string keyword(words_[0]);
  value = words_.size() == 2 ? parse_count(words_[1]) : std::nullopt;
  if (!value) {
    return fail(keyword + " is not a whole number that fits 64 bits", "correct the header");
  }
  if (*value > kMaxFilePoints) {
    return fail(keyword + " " + std::to_string(*value) + " is more than the limit of " +
                    std::to_string(kMaxFilePoints) + " points",
                "correct the header, or split the cloud");
  }
  return true;
}

bool PcdHeaderParser::take_viewpoint() {
  std::array<double, 7> v{};
  bool good = words_.size() == v.size() + 1;
  for (std::size_t i = 0; good && i < v.size(); ++i) {
    const auto value = parse_number(words_[i + 1]);
    good = value.has_value() && std::isfinite(*value);
    if (good) v[i] = *value;
  }
  const double norm = std::sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
  if (!good || !std::isfinite(norm) || norm < 1e-9) {
    return fail("VIEWPOINT is not a translation and a quaternion (tx ty tz qw qx qy qz)",
                "write VIEWPOINT 0 0 0 1 0 0 0 if the pose is not known");
  }
  header_.viewpoint = {v[3] / norm, v[4] / norm, v[5] / norm, v[6] / norm, v[0], v[1], v[2]};
  return true;
}

bool PcdHeaderParser::take_data() {
  const std::string_view kind = words_.size() == 2 ? words_[1] : std::string_view();
  if (kind == "ascii") {
    header_.encoding = PcdEncoding::kAscii;
  } else if (kind == "binary") {
    header_.encoding = PcdEncoding::kBinary;
  } else if (kind == "binary_compressed") {
    header_.encoding = PcdEncoding::kBinaryCompressed;
  } else {
    return fail("DATA " + in_quotes(kind) + " is not known",
                "it must be ascii, binary or binary_compressed");
  }
  return true;
}

bool PcdHeaderParser::take_line(std::string_view keyword) {
  if (keyword == "VERSION") return take_version();
  if (keyword == "FIELDS") return take_fields();
  if (keyword == "TYPE") return take_types();
  if (keyword == "SIZE") return take_counts(keyword, sizes_);
  if (keyword == "COUNT") return take_counts(keyword, counts_);
  if (keyword == "WIDTH") return take_size(width_);
  if (keyword == "HEIGHT") return take_size(height_);
  if (keyword == "POINTS") return take_size(points_);
  if (keyword == "VIEWPOINT") return take_viewpoint();
  return take_data();
}

bool PcdHeaderParser::check_list(std::string_view keyword, std::size_t entries) {
  if (entries == 0 || entries == header_.fields.size()) return true;
  return fail_header(std::string(keyword) + " has " + std::to_string(entries) +
                         " entries, FIELDS has " + std::to_string(header_.fields.size()),
                     "give one for each field");
}

bool PcdHeaderParser::find_axis(std::size_t axis) {
  const std::string name(1, static_cast<char>('x' + axis));
  std::size_t found = 0;
  for (std::size_t i = 0; i < header_.fields.size(); ++i) {
    if (header_.fields[i].name != name) continue;
    header_.xyz[axis] = i;
    ++found;
  }
  if (found != 1) {
    return fail_header("field " + name + (found == 0 ? " is missing" : " appears more than once"),
                       "a point cloud needs x, y and z once each");
  }
  const PcdField& field = header_.fields[header_.xyz[axis]];
  if (field.type != 'F' || (field.size != 4 && field.size != 8) || field.count != 1) {
    return fail_header("field " + name + " has TYPE " + std::string(1, field.type) + " SIZE " +
                           std::to_string(field.size) + " COUNT " + std::to_string(field.count),
                       "write it as TYPE F with SIZE 4 or 8 and COUNT 1");
  }
  return true;
}

bool PcdHeaderParser::finish_layout() {
  if (header_.fields.empty()) return fail_header("FIELDS is missing", "write FIELDS x y z");
  if (!check_list("SIZE", sizes_.size()) || !check_list("TYPE", types_.size()) ||
      !check_list("COUNT", counts_.size())) {
    return false;
  }
  std::uint64_t offset = 0;
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < header_.fields.size(); ++i) {
    PcdField& field = header_.fields[i];
    if (!types_.empty()) field.type = types_[i];
    if (!sizes_.empty()) field.size = sizes_[i];
    if (!counts_.empty()) field.count = counts_[i];
    const bool known = field.size == 1 || field.size == 2 || field.size == 4 || field.size == 8;
    if (!known) {
      return fail_header(
          "field " + in_quotes(field.name) + " has SIZE " + std::to_string(field.size),
          "sizes are 1, 2, 4 and 8");
    }
    field.offset = static_cast<std::uint32_t>(offset);
    field.word = static_cast<std::uint32_t>(word);
    offset += std::uint64_t{field.size} * field.count;
    word += field.count;
    if (offset > kMaxPointBytes) {
      return fail_header("one point has more than " + std::to_string(kMaxPointBytes) + " bytes",
                         "correct SIZE and COUNT");
    }
  }
  header_.point_bytes = static_cast<std::uint32_t>(offset);
  header_.point_words = static_cast<std::uint32_t>(word);
  return find_axis(0) && find_axis(1) && find_axis(2);
}

bool PcdHeaderParser::finish_shape() {
  if (!width_ && !points_) {
    return fail_header("neither WIDTH nor POINTS is given", "write WIDTH, HEIGHT and POINTS");
  }
  // Version .5 files may state POINTS alone; both factors are capped, so the product cannot wrap.
  const std::uint64_t height = height_.value_or(1);
  const std::uint64_t width = width_.value_or(height == 1 ? points_.value_or(0) : 0);
  const std::uint64_t points = points_.value_or(width * height);
  if (width * height != points) {
    return fail_header("WIDTH " + std::to_string(width) + " x HEIGHT " + std::to_string(height) +
                           " is not POINTS " + std::to_string(points),
                       "correct the one that is wrong");
  }
  if (points > kMaxFilePoints) {
    return fail_header(
        "WIDTH x HEIGHT is more than the limit of " + std::to_string(kMaxFilePoints) + " points",
        "correct the header, or split the cloud");
  }
  header_.width = static_cast<std::uint32_t>(width);
  header_.height = static_cast<std::uint32_t>(height);
  header_.points = static_cast<std::size_t>(points);
  return true;
}

bool PcdHeaderParser::finish() {
  return finish_layout() && finish_shape();
}

Result<PcdHeader> PcdHeaderParser::parse() {
  const std::string_view text = as_text(file_).substr(0, kMaxHeaderBytes);
  LineReader reader(text);
  std::string_view line;
  while (reader.next(line)) {
    line_ = reader.line();
    split_words(line, words_);
    if (words_.empty() || words_[0].front() == '#') continue;
    if (words_[0] == "COLUMNS") words_[0] = "FIELDS";  // the oldest files' name for it
    const auto known = std::find(kKeywords.begin(), kKeywords.end(), words_[0]);
    if (known == kKeywords.end()) {
      fail("header word " + in_quotes(words_[0]) + " is not known",
           "check that this is a PCD file, and remove the line");
      return error_;
    }
    if (std::find(seen_.begin(), seen_.end(), *known) != seen_.end()) {
      fail(std::string(*known) + " appears twice", "remove one of the two lines");
      return error_;
    }
    seen_.push_back(*known);
    if (!take_line(*known)) return error_;
    if (*known != "DATA") continue;
    header_.data_offset = reader.offset();
    header_.data_line = line_ + 1;
    if (!finish()) return error_;
    return std::move(header_);
  }
  fail_header("ends without a DATA line",
              "the file is cut short or is not a PCD file: get it anew");
  return error_;
}

}  // namespace

Result<PcdHeader> parse_pcd_header(const std::filesystem::path& path,
                                   std::span<const std::uint8_t> file) {
  return PcdHeaderParser(path, file).parse();
}

}  // namespace planecast
