// The index of each depth among the frame's different depths before an image codec: on stereo and
// structured light a few hundred levels, whose spacing grows with depth as the noise does. The
// table travels in front as differences, so nothing is hidden; on time of flight it grows and does
// not pay.
#include <algorithm>

#include "bench/baselines/byte_io.hpp"
#include "bench/baselines/depth_baselines.hpp"

namespace planecast::baselines {
namespace {

class LatticeIndex : public DepthBaseline {
 public:
  explicit LatticeIndex(std::unique_ptr<DepthBaseline> inner)
      : DepthBaseline(inner->name() + "(lattice index)", inner->setting()),
        inner_(std::move(inner)) {}

  Bytes encode(const DepthImage& image) const override {
    std::vector<std::uint16_t> rank(0x10000, 0);
    for (const std::uint16_t d : image.depth) rank[d] = 1;
    rank[0] = 0;
    Bytes out;
    const auto levels = static_cast<std::uint32_t>(std::count(rank.begin(), rank.end(), 1));
    put_varint(out, levels);
    std::uint32_t before = 0;
    std::uint16_t next = 0;
    for (std::uint32_t d = 1; d < rank.size(); ++d) {
      if (rank[d] == 0) continue;
      rank[d] = ++next;
      put_varint(out, d - before);
      before = d;
    }
    DepthImage index = image;
    for (std::uint16_t& d : index.depth) d = rank[d];
    const Bytes inner = inner_->encode(index);
    out.insert(out.end(), inner.begin(), inner.end());
    return out;
  }

  DepthImage decode(const Bytes& bytes) const override {
    ByteReader reader(bytes);
    std::vector<std::uint16_t> level(reader.take_varint() + 1, 0);
    for (std::size_t i = 1; i < level.size(); ++i)
      level[i] = static_cast<std::uint16_t>(level[i - 1] + reader.take_varint());
    const auto body = reader.rest();
    DepthImage image = inner_->decode(Bytes(body.begin(), body.end()));
    // A near-lossless codec may answer an index beyond the table; the nearest one is meant.
    for (std::uint16_t& d : image.depth) d = level[std::min<std::size_t>(d, level.size() - 1)];
    return image;
  }

 private:
  std::unique_ptr<DepthBaseline> inner_;
};

}  // namespace

std::unique_ptr<DepthBaseline> lattice_index(std::unique_ptr<DepthBaseline> inner) {
  return std::make_unique<LatticeIndex>(std::move(inner));
}

}  // namespace planecast::baselines
