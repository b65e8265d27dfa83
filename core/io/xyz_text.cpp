#include "core/io/xyz_text.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/io/cloud_builder.hpp"
#include "core/io/file_bytes.hpp"
#include "core/io/io_error.hpp"
#include "core/io/text.hpp"

namespace planecast {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view without_comment(std::string_view line, std::string_view& comment) {
  const std::size_t at = std::min(line.find('#'), line.find("//"));
  comment = at == std::string_view::npos ? std::string_view() : line.substr(at);
  return line.substr(0, at);
}

// Splits a line into columns; false when it is separated in more than one way ("1,5 2,5 3,5").
bool split_columns(std::string_view line, std::vector<std::string_view>& words) {
  words.clear();
  line = trimmed(line);
  unsigned kinds = 0;
  std::size_t at = 0;
  while (at <= line.size() && !line.empty()) {
    const std::size_t end = std::min(line.find_first_of(",; \t\v\f\r", at), line.size());
    words.push_back(line.substr(at, end - at));
    if (end == line.size()) break;
    std::size_t marks = 0;
    unsigned kind = 0;
    for (at = end; at < line.size(); ++at) {
      if (line[at] == ',' || line[at] == ';') {
        kind |= line[at] == ',' ? 1U : 2U;
        ++marks;
      } else if (!is_space(line[at])) {
        break;
      }
    }
    for (; marks > 1; --marks) words.emplace_back();  // "1,,2": the empty column keeps its place
    kinds |= kind != 0 ? kind : 4U;
  }
  return (kinds & (kinds - 1)) == 0;
}

class XyzParser {
 public:
  explicit XyzParser(const std::filesystem::path& path) : path_(path) {}

  Result<PointCloud> parse(std::string_view text);

 private:
  bool fail(std::string_view what, std::string_view mend) {
    error_ = file_error(path_, at_line(line_), what, mend);
    return false;
  }
  bool take_line(std::string_view line);
  bool take_preamble(bool separable);
  bool take_point(bool separable);
  bool start_points();
  void remember_names(std::string_view line);
  bool check_declared();
  std::vector<std::string> dropped() const;

  const std::filesystem::path& path_;
  std::size_t line_ = 0;
  std::vector<std::string_view> words_;
  std::vector<std::string> names_;               // of the columns, when a line names x, y and z
  std::array<std::size_t, 3> axes_ = {0, 1, 2};  // column of each
  std::size_t columns_ = 0;                      // 0 until the first point
  bool has_header_ = false;
  std::optional<std::uint64_t> declared_;
  std::vector<Point3d> points_;
  Error error_;
};

void XyzParser::remember_names(std::string_view line) {
  std::string plain(line);
  for (char& c : plain) {
    if (c == '#' || c == '/' || c == ',' || c == ';' || c == '"') c = ' ';
  }
  std::vector<std::string_view> words;
  split_words(plain, words);
  std::vector<std::string> names;
  for (const std::string_view word : words) names.push_back(lower_case(word));
  for (const char* axis : {"x", "y", "z"}) {
    if (std::count(names.begin(), names.end(), axis) != 1) return;
  }
  names_ = std::move(names);
}

// Before the first point: at most one header line and one line with the number of points.
bool XyzParser::take_preamble(bool separable) {
  // A line with any number in it is a point or an error: taking it for a header would lose it.
  const bool numbers = std::any_of(words_.begin(), words_.end(), [](std::string_view word) {
    return parse_number(word).has_value();
  });
  if (words_.size() == 1 && !declared_) {
    declared_ = parse_count(words_[0]);
    if (declared_) return true;
  }
  if (numbers || has_header_) return start_points() && take_point(separable);
  has_header_ = true;
  return true;
}

bool XyzParser::start_points() {
  if (words_.size() < 3) {
    return fail("there are " + std::to_string(words_.size()) + " values, a point needs x y z",
                "correct the line, or mark it as a comment with #");
  }
  columns_ = words_.size();
  if (names_.size() != columns_) names_.clear();  // not the names of these columns
  for (std::size_t a = 0; a < 3 && !names_.empty(); ++a) {
    const std::string name(1, static_cast<char>('x' + a));
    axes_[a] =
        static_cast<std::size_t>(std::find(names_.begin(), names_.end(), name) - names_.begin());
  }
  return true;
}

bool XyzParser::take_point(bool separable) {
  if (!separable) {
    return fail("the columns are separated in more than one way",
                "use one of space, comma or semicolon, and a point for decimals");
  }
  if (words_.size() != columns_) {
    return fail("there are " + std::to_string(words_.size()) + " values, the lines before have " +
                    std::to_string(columns_),
                "the file may be cut short: correct the line or get the file anew");
  }
  std::array<double, 3> v{};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto value = parse_number(words_[axes_[a]]);
    if (!value) {
      return fail(in_quotes(words_[axes_[a]]) + " is not a number",
                  "correct the line, or mark it as a comment with #");
    }
    v[a] = *value;
  }
  if (points_.size() == kMaxFilePoints) {
    return fail("there are more than " + std::to_string(kMaxFilePoints) + " points",
                "split the cloud");
  }
  points_.push_back({v[0], v[1], v[2]});
  return true;
}

bool XyzParser::take_line(std::string_view line) {
  std::string_view comment;
  const std::string_view content = without_comment(line, comment);
  if (columns_ == 0 && !comment.empty() && trimmed(content).empty()) remember_names(comment);
  const bool separable = split_columns(content, words_);
  if (words_.empty()) return true;
  if (columns_ != 0) return take_point(separable);
  if (!has_header_) remember_names(content);
  return take_preamble(separable);
}

bool XyzParser::check_declared() {
  if (!declared_ || *declared_ == points_.size()) return true;
  return fail("the file promises " + std::to_string(*declared_) + " points and holds " +
                  std::to_string(points_.size()),
              "it may be cut short: correct the number or get the file anew");
}

std::vector<std::string> XyzParser::dropped() const {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < columns_; ++i) {
    if (std::find(axes_.begin(), axes_.end(), i) != axes_.end()) continue;
    out.push_back(names_.empty() ? "column " + std::to_string(i + 1) : names_[i]);
  }
  return out;
}

Result<PointCloud> XyzParser::parse(std::string_view text) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  LineReader reader(text);
  std::string_view line;
  while (reader.next(line)) {
    line_ = reader.line();
    if (!take_line(line)) return error_;
  }
  if (!check_declared()) return error_;
  if (points_.empty() && has_header_ && names_.empty()) {
    fail("there is no point in the file", "check that these are points as text: x y z in a line");
    return error_;
  }
  return build_cloud(path_, static_cast<std::uint32_t>(points_.size()), 1, points_,
                     CoordinateKind::kWide, dropped());
}

template <class T>
void append_line(std::string& out, T x, T y, T z) {
  append_number(out, x);
  out += ' ';
  append_number(out, y);
  out += ' ';
  append_number(out, z);
  out += '\n';
}

}  // namespace

Result<PointCloud> read_xyz_text(const std::filesystem::path& path) {
  const auto file = read_file_bytes(path);
  if (!file) return file.error();
  return parse_xyz_text(path, *file);
}

Result<PointCloud> parse_xyz_text(const std::filesystem::path& path,
                                  std::span<const std::uint8_t> file) {
  return XyzParser(path).parse(as_text(file));
}

Result<WriteReport> write_xyz_text(const std::filesystem::path& path, const PointCloud& cloud) {
  WriteReport report;
  std::string text;
  for (const Point3f& p : cloud.points) {
    if (!is_valid(p)) {
      ++report.points_left_out;
      continue;
    }
    const Point3d q = absolute_point(cloud, p);
    has_origin(cloud) ? append_line(text, q.x, q.y, q.z) : append_line(text, p.x, p.y, p.z);
    ++report.points_written;
  }
  const Result<Done> written = write_file_text(path, text);
  if (!written) return written.error();
  return report;
}

}  // namespace planecast
