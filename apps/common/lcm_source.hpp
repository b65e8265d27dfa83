// Frames from LCM: plain drake.lcmt_point_cloud messages of one channel, organised ones only. What
// is refused is counted by cause, with a sentence that names the mend.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "apps/common/frame_source.hpp"
#include "transport/lcm_link.hpp"

namespace planecast {

/// What inputs from LCM start with: "lcm:CHANNEL".
inline constexpr std::string_view kLcmInputPrefix = "lcm:";

/// messages = clouds + refused_*; clouds = given by next() + passed_over + waiting.
struct LcmSourceCounts {
  std::uint64_t messages = 0;
  std::uint64_t clouds = 0;
  std::uint64_t refused_malformed = 0;  ///< not a point cloud, or one that contradicts itself
  std::uint64_t passed_over = 0;        ///< a newer cloud came before next() took it
};

class LcmSource : public FrameSource {
 public:
  /// Most points of a cloud; larger ones are refused as malformed.
  static constexpr std::size_t kMaxPoints = std::size_t{1} << 23U;

  /// Listens to `channel` on a link opened for receiving. Errors of PlainSubscriber::create.
  static Result<std::unique_ptr<LcmSource>> open(const std::string& channel,
                                                 std::shared_ptr<LcmLink> link);
  ~LcmSource() override;

  /// Waits for the next cloud; false once interrupted. stamp_ns is the message's utime, frame_id
  /// its frame name.
  Result<bool> next(SensorFrame& frame) override;

  /// The same for at most `timeout_ns`; false as well when none came.
  bool next_within(SensorFrame& frame, std::int64_t timeout_ns);

  /// A live source starts where it is.
  void rewind() override {}
  std::optional<std::uint64_t> count() const override { return std::nullopt; }

  /// Any thread: ends every next(), now and later.
  void interrupt();

  /// Any thread.
  LcmSourceCounts counts() const;

  /// Any thread: why the last refused message was refused, with the mend; "" when none was.
  std::string refusal() const;

 private:
  struct Impl;
  explicit LcmSource(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace planecast
