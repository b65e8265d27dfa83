// What a key packet says: all that a receiver must know to decode every slice of a stream.
// Integers only, so that both ends and every machine hold the same values.
#pragma once

#include <array>
#include <cstdint>

#include "core/base/status.hpp"
#include "core/sensor/camera.hpp"
#include "core/sensor/noise_model.hpp"
#include "core/sensor/pose_fixed.hpp"

namespace planecast {

/// What one frame of the stream is.
enum class FrameKind : std::uint8_t {
  kDepth = 0,     ///< an integer depth image; points are regenerated along rays
  kRawCloud = 1,  ///< an organised grid of float32 x, y, z, coded losslessly
  kPoints = 2,    ///< a list of points without order: point lists and surface patches
};

/// Which error contract holds (DESIGN 4).
enum class ToleranceKind : std::uint8_t {
  kLossless = 0,  ///< every depth count comes back
  kMetres = 1,    ///< 3-D distance of each point from its reconstruction
  kSigma = 2,     ///< the same, in multiples of the noise model's sigma
  kSurfaces = 3,  ///< on-surface points carry no correction; the bound is K sigma
};

/// Least C of a lattice, in 1/256 count: below two counts its spacing reaches the whole range.
inline constexpr std::uint32_t kMinLatticeCQ8 = 512;

/// Levels of a sensor whose depth is C / (k + offset), k = 1, 2, ..., rounded or cut to whole
/// counts; c_q8 = 0: every depth count is a level. C in depth counts.
struct Lattice {
  std::uint32_t c_q8 = 0;
  std::uint32_t offset_q16 = 0;  ///< 0 .. 65535
  bool truncated = false;        ///< counts are cut, not rounded
  bool present() const noexcept { return c_q8 != 0; }
  friend bool operator==(const Lattice&, const Lattice&) = default;
};

/// How integer depth becomes the float32 z of the input (see z_grid.hpp).
enum class ZRule : std::uint8_t { kProductInDouble = 0, kProductInFloat = 1, kPrinted7 = 2 };

/// Whose clock stamps are read from.
enum class ClockDomain : std::uint8_t { kUnknown = 0, kMonotonic = 1, kRealtime = 2, kSensor = 3 };

/// How the points of a patch are laid out inside its boundary.
enum class FillMode : std::uint8_t {
  kLattice = 0,  ///< evenly spaced
  kRandom = 1,   ///< at random, uniform over the area
};

/// Most points that a frame of a kPoints stream may have.
inline constexpr std::uint32_t kMaxFramePoints = std::uint32_t{1} << 25U;
/// Most of a step between coded points: 1 m.
inline constexpr std::uint64_t kMaxPointStepPm = 1'000'000'000'000;
/// Most of the bound of coded points, in steps.
inline constexpr std::uint32_t kMaxPointToleranceSteps = 1U << 20U;
/// Most of a step of patches: 1 m.
inline constexpr std::uint32_t kMaxPatchUnitNm = 1'000'000'000;

/// What only kPoints streams have. Points are counted in steps from the cloud's own zero, which
/// lies at StreamConfig::axes' translation in the coordinates of the input.
struct PointStream {
  std::uint32_t max_points = 0;       ///< most points of a frame, 1 .. kMaxFramePoints
  std::uint64_t step_pm = 0;          ///< spacing of the grid [pm]; 0: float32 bits are coded
  std::uint32_t tolerance_steps = 0;  ///< bound of coded points; what grid and float32 take is off
  std::uint32_t patch_unit_nm = 0;    ///< a step of every coordinate of a patch; 1 ..
  FillMode fill = FillMode::kLattice;
  std::uint32_t seed = 0;  ///< of FillMode::kRandom
  friend bool operator==(const PointStream&, const PointStream&) = default;
};

inline constexpr std::size_t kMaxFrameIdBytes = 31;

/// The content of a key packet. Ranges are checked by check_config().
struct StreamConfig {
  std::uint8_t stream = 0;    ///< number of the stream on its channel
  std::uint32_t session = 0;  ///< random per start of the sender
  std::int64_t epoch_ns = 0;  ///< stamps in slices count from here
  ClockDomain clock = ClockDomain::kUnknown;
  std::uint32_t boot_id = 0;     ///< hash of the machine's boot id; equal ids share a clock
  std::uint16_t period_ms = 33;  ///< nominal frame period

  FrameKind kind = FrameKind::kDepth;
  CameraModel camera;
  ZRule z_rule = ZRule::kProductInDouble;
  Lattice lattice;
  PointStream points;  ///< kPoints, which has no camera, z rule or lattice: all zero there
  NoiseModel noise;

  ToleranceKind tolerance = ToleranceKind::kLossless;
  std::uint32_t tolerance_100nm = 0;  ///< kMetres: the bound left for depth, in 0.1 um
  std::uint32_t sigmas_q16 = 0;       ///< kSigma, kSurfaces: multiples of sigma
  bool drop_off_surface = false;      ///< kSurfaces: points off the surfaces were dropped
  bool effort_best = false;
  bool mirror_y = false;  ///< the cloud's axes are left-handed: y is flipped before `axes`

  PoseFixed pose;  ///< sensor in the world
  PoseFixed axes;  ///< optical axes in the cloud's own frame (estimated clouds); kPoints: its
                   ///< translation is the zero of the points, handed on and never added
  std::array<char, kMaxFrameIdBytes + 1> frame_id{};  ///< NUL-terminated ASCII

  friend bool operator==(const StreamConfig&, const StreamConfig&) = default;
};

/// The bound of a point on no surface [pm] of a kPoints stream: of metres, or multiples of sigma;
/// 0 when lossless.
std::uint64_t point_bound_pm(const StreamConfig& config) noexcept;

/// Checks every range: kOk or kFieldRange. Used on configurations from users and from the wire.
Status check_config(const StreamConfig& config) noexcept;

}  // namespace planecast
