// Plain point clouds as existing LCM viewers and sources speak them: drake.lcmt_point_cloud,
// written and read by hand within the caller's memory. Viewers accept only x, y, z as packed
// float32, and only clouds that promise finite points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/status.hpp"
#include "transport/lcm_link.hpp"

namespace planecast {

inline constexpr std::uint64_t kDrakePointCloudFingerprint = 0x17f2c128b5d25a95ULL;

/// Channel names viewers listen to start with this.
inline constexpr std::string_view kDrakeChannelPrefix = "DRAKE_POINT_CLOUD_";

/// Most points whose message still is one datagram, whatever the frame and channel names.
inline constexpr std::size_t kDrakeDatagramPoints = 5400;

/// Longest frame name written.
inline constexpr std::size_t kDrakeMaxFrameName = 255;

/// Bytes of a message of `points` points.
std::size_t drake_point_cloud_bytes(std::size_t points, std::string_view frame_name) noexcept;

/// Writes the finite points of `xyz` (n x 3, row-major, metres, in the frame `frame_name` names),
/// evenly thinned to at most `max_points`. Allocates nothing, O(n).
/// kFieldRange: xyz is not n x 3 or the name is too long. kTooLarge: `out` is too small.
Status encode_drake_point_cloud(std::int64_t utime, std::string_view frame_name,
                                std::span<const float> xyz, std::size_t max_points,
                                std::span<std::uint8_t> out, std::size_t& size) noexcept;

/// A received cloud, pointing into its message.
struct DrakePointCloud {
  std::int64_t utime = 0;  ///< [us]
  std::string_view frame_name;
  std::uint32_t width = 0;   ///< points a row
  std::uint32_t height = 0;  ///< rows; 1: not organised
  bool strictly_finite = false;
  std::uint32_t point_step = 0;         ///< bytes from point to point
  std::uint64_t row_step = 0;           ///< bytes from row to row
  std::uint32_t offset[3] = {0, 0, 0};  ///< of x, y, z within a point
  std::span<const std::uint8_t> data;

  std::size_t points() const noexcept { return std::size_t{width} * height; }

  /// x, y, z of one point, as sent (NaN where a sensor had no reading); row < height,
  /// column < width.
  void point(std::uint32_t row, std::uint32_t column, float out[3]) const noexcept;
};

/// Reads a message; `out` then points into it. Allocates nothing; any bytes are safe.
/// kTruncated, kTrailingBytes, kBadMagic (another type), kFieldRange (sizes that contradict each
/// other), kTooLarge (over `max_points`), kUnsupportedVersion (big-endian, or no float32 x, y, z).
Status decode_drake_point_cloud(std::span<const std::uint8_t> message, std::size_t max_points,
                                DrakePointCloud& out) noexcept;

/// Publishes clouds for viewers from one buffer taken at construction; one thread.
class DrakePublisher {
 public:
  /// `max_points`: kDrakeDatagramPoints, or more where fragments are acceptable (this host only).
  /// kUsage: the channel or frame name is not usable.
  static Result<std::unique_ptr<DrakePublisher>> create(const std::string& channel,
                                                        const std::string& frame_name,
                                                        std::size_t max_points,
                                                        std::shared_ptr<LcmLink> link);

  /// Sends the cloud, thinned to max_points; may block in the kernel. As encode_drake_point_cloud,
  /// and kNetwork.
  Status publish(std::int64_t utime, std::span<const float> xyz) noexcept;

 private:
  DrakePublisher(std::string channel, std::string frame_name, std::size_t max_points,
                 std::shared_ptr<LcmLink> link);
  std::string channel_;
  std::string frame_name_;
  std::size_t max_points_;
  std::shared_ptr<LcmLink> link_;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace planecast
