#include "core/io/file_list.hpp"

#include <algorithm>
#include <optional>
#include <system_error>

#include "core/io/file_kind.hpp"
#include "core/io/io_error.hpp"
#include "core/io/natural_order.hpp"
#include "core/io/nearest_name.hpp"

namespace planecast {
namespace {

namespace fs = std::filesystem;

struct FolderContent {
  std::vector<fs::path> files;     // visible regular files in natural order
  std::vector<std::string> names;  // of everything visible, folders too
  std::error_code code;
};

FolderContent list_folder(const fs::path& folder) {
  FolderContent content;
  fs::directory_iterator it(folder, content.code);
  for (const fs::directory_iterator end; !content.code && it != end; it.increment(content.code)) {
    const std::string name = it->path().filename().string();
    if (name.empty() || name.front() == '.') continue;
    content.names.push_back(name);
    std::error_code ignored_code;  // a dangling link is no file, and no reason to stop
    if (it->is_regular_file(ignored_code)) content.files.push_back(it->path());
  }
  std::sort(content.files.begin(), content.files.end(), [](const fs::path& a, const fs::path& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  std::sort(content.names.begin(), content.names.end(), natural_less);
  return content;
}

Error missing(const fs::path& path) {
  fs::path clean = path.lexically_normal();
  if (!clean.has_filename()) clean = clean.parent_path();  // "folder/"
  const fs::path parent = clean.has_parent_path() ? clean.parent_path() : fs::path(".");
  std::error_code code;
  if (!fs::is_directory(parent, code)) {
    return file_error(path, "", "no such file or folder (" + parent.string() + " does not exist)",
                      "check the path", Status::kNotFound);
  }
  const FolderContent content = list_folder(parent);
  const auto near = nearest_name(clean.filename().string(), content.names);
  const std::string mend =
      near ? "did you mean " +
                 (clean.has_parent_path() ? parent / *near : fs::path(*near)).string() + "?"
           : std::string("check the path");
  return file_error(path, "", "no such file or folder", mend, Status::kNotFound);
}

Error nothing_readable(const fs::path& folder, const FolderContent& content) {
  if (!content.files.empty()) {
    // A format by name tells more than the LICENSE beside it.
    auto example = std::find_if(content.files.begin(), content.files.end(), is_known_format);
    if (example == content.files.end()) example = content.files.begin();
    return file_error(folder, "", "the folder holds no file that can be read",
                      refusal(*example).message);
  }
  const std::string mend = content.names.empty()
                               ? std::string("give a folder of frames")
                               : "folders inside are not searched: name one, e.g. " +
                                     (folder / content.names.front()).string();
  return file_error(folder, "", "the folder holds no files", mend);
}

// The one kind of frame in a folder, or an error that names two files of different kinds.
Result<FileKind> kind_of_folder(const fs::path& folder, const FolderContent& content) {
  std::optional<fs::path> first;
  bool has_text = false;
  for (const fs::path& file : content.files) {
    const FileKind kind = file_kind(file);
    if (kind == FileKind::kUnread) continue;
    if (kind == FileKind::kXyzText) {
      has_text = true;
    } else if (!first) {
      first = file;
    } else if (file_kind(*first) != kind) {
      return file_error(folder, "",
                        "the folder holds several kinds of frames: " + first->filename().string() +
                            " (" + std::string(to_string(file_kind(*first))) + ") and " +
                            file.filename().string() + " (" + std::string(to_string(kind)) + ")",
                        "name the files, or keep each kind in its own folder");
    }
  }
  if (first) return file_kind(*first);
  if (has_text) return FileKind::kXyzText;
  return nothing_readable(folder, content);
}

std::optional<Error> expand_folder(const fs::path& folder, std::vector<fs::path>& files,
                                   std::vector<fs::path>* ignored) {
  const FolderContent content = list_folder(folder);
  if (content.code) {
    return file_error(folder, "", "the folder cannot be listed (" + content.code.message() + ")",
                      "check the permissions");
  }
  const Result<FileKind> kind = kind_of_folder(folder, content);
  if (!kind) return kind.error();
  for (const fs::path& file : content.files) {
    if (file_kind(file) == *kind) {
      files.push_back(file);
    } else if (ignored != nullptr) {
      ignored->push_back(file);
    }
  }
  return std::nullopt;
}

}  // namespace

Result<std::vector<fs::path>> expand_inputs(std::span<const std::string> inputs,
                                            std::vector<fs::path>* ignored) {
  if (inputs.empty()) return {Status::kUsage, "no input given; name a file or a folder of frames"};
  std::vector<fs::path> files;
  for (const std::string& input : inputs) {
    const fs::path path(input);
    std::error_code code;
    const fs::file_status status = fs::status(path, code);
    if (!fs::exists(status)) return missing(path);
    if (!fs::is_directory(status)) {
      files.push_back(path);
    } else if (const auto error = expand_folder(path, files, ignored)) {
      return *error;
    }
  }
  return files;
}

}  // namespace planecast
