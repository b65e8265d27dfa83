// What can go wrong, as one small enum for the hot path and a value-or-message for the cold path.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace planecast {

/// Outcome of a hot-path call. Values are written out and never renumbered: goldens name them.
enum class [[nodiscard]] Status : std::uint8_t{
    kOk = 0,
    // Configuration and use
    kBadConfig = 10,      ///< a setting is out of its range
    kFrameTooLarge = 11,  ///< more points than the configured max_points
    kNoSlot = 12,         ///< every frame slot is in use; the new frame was dropped
    kStopped = 13,        ///< the pipeline is not running
    kOutOfArena = 14,     ///< the arena is sealed or too small
    kWrongSize = 15,      ///< width or height differ from the stream's
    kBoundExceeded = 16,  ///< a point would leave its bound (an internal check failed)
    // Bytes from outside
    kTruncated = 30,           ///< the packet ends before its content does
    kBadMagic = 31,            ///< not one of our packets
    kUnsupportedVersion = 32,  ///< wire major version unknown
    kReservedBits = 33,        ///< a reserved bit is not zero
    kBadCheck = 34,            ///< the check does not match the bytes
    kFieldRange = 35,          ///< a field is outside its allowed range
    kUnknownKey = 36,          ///< the key packet this slice names has not arrived
    kBadSymbol = 37,           ///< an entropy-coded value is impossible
    kTooLarge = 38,            ///< decoding would need more memory than the stream allows
    kTrailingBytes = 39,       ///< bytes are left after the content
    // Files and network (cold path)
    kNotFound = 50,
    kUnreadable = 51,  ///< the file is corrupt, or of a kind that is not read
    kWriteFailed = 52,
    kNetwork = 53,
    kUsage = 54,
};

/// Name of a status as written in documents and goldens, e.g. "kTruncated".
std::string_view to_string(Status status) noexcept;

/// A status with the sentence a person needs: the file, the place and the mend. Cold path only.
struct Error {
  Status status = Status::kOk;
  std::string message;
};

/// A value or an Error; for files, configuration and start-up, never for the hot path.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : content_(std::move(error)) {}  // NOLINT(google-explicit-constructor)
  Result(Status status, std::string message) : content_(Error{status, std::move(message)}) {}

  bool ok() const noexcept { return std::holds_alternative<T>(content_); }
  explicit operator bool() const noexcept { return ok(); }
  T& value() { return std::get<T>(content_); }
  const T& value() const { return std::get<T>(content_); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  const Error& error() const { return std::get<Error>(content_); }

 private:
  std::variant<T, Error> content_;
};

/// Result of a cold-path call that returns nothing.
struct Done {};

}  // namespace planecast
