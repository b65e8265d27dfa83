#include "apps/common/exit_codes.hpp"

namespace planecast {

ExitCode exit_code(Status status) noexcept {
  switch (status) {
    case Status::kOk:
      return ExitCode::kDone;
    case Status::kUsage:
    case Status::kBadConfig:
      return ExitCode::kUsage;
    case Status::kNotFound:
    case Status::kUnreadable:
    case Status::kTruncated:
    case Status::kBadMagic:
    case Status::kUnsupportedVersion:
    case Status::kReservedBits:
    case Status::kBadCheck:
    case Status::kFieldRange:
    case Status::kUnknownKey:
    case Status::kBadSymbol:
    case Status::kTooLarge:
    case Status::kTrailingBytes:
    case Status::kWrongSize:
    case Status::kFrameTooLarge:
      return ExitCode::kBadInput;
    case Status::kNetwork:
      return ExitCode::kNetwork;
    case Status::kBoundExceeded:
      return ExitCode::kBoundExceeded;
    case Status::kNoSlot:
    case Status::kStopped:
    case Status::kOutOfArena:
    case Status::kWriteFailed:
      return ExitCode::kFailed;
  }
  return ExitCode::kFailed;
}

}  // namespace planecast
