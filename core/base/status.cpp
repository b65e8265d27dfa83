#include "core/base/status.hpp"

namespace planecast {

std::string_view to_string(Status status) noexcept {
  switch (status) {
    case Status::kOk:
      return "kOk";
    case Status::kBadConfig:
      return "kBadConfig";
    case Status::kFrameTooLarge:
      return "kFrameTooLarge";
    case Status::kNoSlot:
      return "kNoSlot";
    case Status::kStopped:
      return "kStopped";
    case Status::kOutOfArena:
      return "kOutOfArena";
    case Status::kWrongSize:
      return "kWrongSize";
    case Status::kBoundExceeded:
      return "kBoundExceeded";
    case Status::kTruncated:
      return "kTruncated";
    case Status::kBadMagic:
      return "kBadMagic";
    case Status::kUnsupportedVersion:
      return "kUnsupportedVersion";
    case Status::kReservedBits:
      return "kReservedBits";
    case Status::kBadCheck:
      return "kBadCheck";
    case Status::kFieldRange:
      return "kFieldRange";
    case Status::kUnknownKey:
      return "kUnknownKey";
    case Status::kBadSymbol:
      return "kBadSymbol";
    case Status::kTooLarge:
      return "kTooLarge";
    case Status::kTrailingBytes:
      return "kTrailingBytes";
    case Status::kNotFound:
      return "kNotFound";
    case Status::kUnreadable:
      return "kUnreadable";
    case Status::kWriteFailed:
      return "kWriteFailed";
    case Status::kNetwork:
      return "kNetwork";
    case Status::kUsage:
      return "kUsage";
  }
  return "unknown";
}

}  // namespace planecast
