#include "core/io/ply_header.hpp"

#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "core/io/file_bytes.hpp"
#include "core/io/io_error.hpp"
#include "core/io/text.hpp"

namespace planecast {
namespace {

std::optional<PlyType> type_of(std::string_view name) noexcept {
  constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes = {{
      {"char", PlyType::kI8},
      {"int8", PlyType::kI8},
      {"uchar", PlyType::kU8},
      {"uint8", PlyType::kU8},
      {"short", PlyType::kI16},
      {"int16", PlyType::kI16},
      {"ushort", PlyType::kU16},
      {"uint16", PlyType::kU16},
      {"int", PlyType::kI32},
      {"int32", PlyType::kI32},
      {"uint", PlyType::kU32},
      {"uint32", PlyType::kU32},
      {"float", PlyType::kF32},
      {"float32", PlyType::kF32},
      {"double", PlyType::kF64},
      {"float64", PlyType::kF64},
  }};
  for (const auto& [known, type] : kTypes) {
    if (known == name) return type;
  }
  return std::nullopt;
}

class PlyHeaderParser {
 public:
  PlyHeaderParser(const std::filesystem::path& path, std::span<const std::uint8_t> file)
      : path_(path), file_(file) {}

  Result<PlyHeader> parse();

 private:
  // A failed step sets error_ and returns false, so that steps chain with &&.
  bool fail(std::string_view what, std::string_view mend) {
    error_ = file_error(path_, at_line(line_), what, mend);
    return false;
  }
  bool fail_header(std::string_view what, std::string_view mend) {
    error_ = file_error(path_, "header", what, mend);
    return false;
  }
  bool take_line();
  bool take_format();
  bool take_element();
  bool take_property();
  bool finish();

  const std::filesystem::path& path_;
  std::span<const std::uint8_t> file_;
  std::size_t line_ = 0;
  std::vector<std::string_view> words_;
  bool has_format_ = false;
  PlyHeader header_;
  Error error_;
};

bool PlyHeaderParser::take_format() {
  const std::string_view kind = words_.size() == 3 ? words_[1] : std::string_view();
  if (has_format_) return fail("format appears twice", "remove one of the two lines");
  has_format_ = true;
  if (kind == "ascii") {
    header_.encoding = PlyEncoding::kAscii;
  } else if (kind == "binary_little_endian") {
    header_.encoding = PlyEncoding::kLittleEndian;
  } else if (kind == "binary_big_endian") {
    header_.encoding = PlyEncoding::kBigEndian;
  } else {
    return fail("format " + in_quotes(kind) + " is not known",
                "it must be ascii, binary_little_endian or binary_big_endian, then 1.0");
  }
  return words_[2] == "1.0" || fail("PLY version " + in_quotes(words_[2]) + " is not known",
                                    "write the file as version 1.0");
}

bool PlyHeaderParser::take_element() {
  const auto count = words_.size() == 3 ? parse_count(words_[2]) : std::nullopt;
  if (!count) {
    return fail("an element needs a name and a count that is a whole number",
                "correct the line, e.g. element vertex 1000");
  }
  PlyElement element;
  element.name = words_[1];
  element.count = *count;
  header_.elements.push_back(std::move(element));
  return true;
}

bool PlyHeaderParser::take_property() {
  if (header_.elements.empty()) return fail("a property before any element", "correct the header");
  PlyProperty property;
  property.is_list = words_.size() == 5 && words_[1] == "list";
  if (!property.is_list && words_.size() != 3) {
    return fail("a property needs a type and a name", "correct the line, e.g. property float x");
  }
  const auto type = type_of(words_[words_.size() - 2]);
  const auto count_type = property.is_list ? type_of(words_[2]) : PlyType::kU8;
  if (!type || !count_type || *count_type >= PlyType::kF32) {
    return fail("a type of property " + in_quotes(words_.back()) + " is not known or not allowed",
                "types are char, uchar, short, ushort, int, uint, float and double; a list's "
                "length must be an integer");
  }
  property.name = words_.back();
  property.type = *type;
  property.count_type = *count_type;
  header_.elements.back().properties.push_back(std::move(property));
  return true;
}

bool PlyHeaderParser::take_line() {
  if (words_[0] == "comment" || words_[0] == "obj_info") return true;
  if (words_[0] == "format") return take_format();
  if (words_[0] == "element") return take_element();
  if (words_[0] == "property") return take_property();
  return fail("header word " + in_quotes(words_[0]) + " is not known",
              "check that this is a PLY file, and remove the line");
}

bool PlyHeaderParser::finish() {
  if (!has_format_) return fail_header("format is missing", "write e.g. format ascii 1.0");
  std::size_t found = 0;
  for (std::size_t i = 0; i < header_.elements.size(); ++i) {
    if (header_.elements[i].name != "vertex") continue;
    header_.vertex = i;
    ++found;
  }
  if (found != 1) {
    return fail_header(found == 0 ? "there is no vertex element" : "there are two vertex elements",
                       "a point cloud needs one element vertex with x, y and z");
  }
  const PlyElement& vertex = header_.elements[header_.vertex];
  for (const std::string_view axis : {"x", "y", "z"}) {
    std::size_t scalars = 0;
    std::size_t all = 0;
    for (const PlyProperty& property : vertex.properties) {
      if (property.name != axis) continue;
      ++all;
      if (!property.is_list) ++scalars;
    }
    if (all != 1 || scalars != 1) {
      return fail_header("vertex needs the property " + std::string(axis) + " once, as a number",
                         "write property float x, y and z");
    }
  }
  if (vertex.count > kMaxFilePoints) {
    return fail_header("vertex count " + std::to_string(vertex.count) +
                           " is more than the limit of " + std::to_string(kMaxFilePoints),
                       "correct the header, or split the cloud");
  }
  return true;
}

Result<PlyHeader> PlyHeaderParser::parse() {
  LineReader reader(as_text(file_).substr(0, kMaxHeaderBytes));
  std::string_view line;
  if (!reader.next(line) || trimmed(line) != "ply") {
    return file_error(path_, at_line(1), "the file does not start with 'ply'",
                      "check that this is a PLY file");
  }
  while (reader.next(line)) {
    line_ = reader.line();
    split_words(line, words_);
    if (words_.empty()) continue;
    if (words_[0] != "end_header") {
      if (!take_line()) return error_;
      continue;
    }
    header_.data_offset = reader.offset();
    header_.data_line = line_ + 1;
    if (!finish()) return error_;
    return std::move(header_);
  }
  fail_header("ends without an end_header line",
              "the file is cut short or is not a PLY file: get it anew");
  return error_;
}

}  // namespace

std::size_t ply_type_bytes(PlyType type) noexcept {
  constexpr std::array<std::size_t, 8> kBytes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kBytes[static_cast<std::size_t>(type)];
}

Result<PlyHeader> parse_ply_header(const std::filesystem::path& path,
                                   std::span<const std::uint8_t> file) {
  return PlyHeaderParser(path, file).parse();
}

}  // namespace planecast
