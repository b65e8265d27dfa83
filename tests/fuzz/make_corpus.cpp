// Writes the first inputs of every fuzz target: make_corpus FOLDER. From the golden vectors for the
// wire; small files of every encoding for the readers.
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/base/random.hpp"
#include "core/io/depth_png.hpp"
#include "core/io/file_bytes.hpp"
#include "core/io/kitti_bin.hpp"
#include "core/io/pcd.hpp"
#include "core/io/ply.hpp"
#include "core/io/xyz_text.hpp"
#include "core/wire/packet_header.hpp"
#include "core/wire/plc_format.hpp"
#include "tests/core/io/lzf_pack.hpp"
#include "tests/fuzz/fuzz_target.hpp"
#include "tests/fuzz/golden_streams.hpp"
#include "tests/fuzz/slice_input.hpp"

namespace planecast::test {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

fs::path root;

fs::path place(const std::string& target, const std::string& name) {
  fs::create_directories(root / target);
  return root / target / name;
}

void put(const std::string& target, const std::string& name, std::span<const std::uint8_t> bytes) {
  claim(write_file_bytes(place(target, name), bytes).ok(), "an input is written");
}

void put_text(const std::string& target, const std::string& name, const std::string& text) {
  claim(write_file_text(place(target, name), text).ok(), "an input is written");
}

void wire(const fs::path& golden) {
  const auto streams = golden_streams(golden);
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const GoldenStream& stream = streams[i];
    const std::span<const std::uint8_t> key(stream.key);
    put("key", stream.name, key.subspan(kPacketHeaderBytes));
    put("file", stream.name, stream.file);
    Bytes bodies{static_cast<std::uint8_t>(i)};
    Bytes packets{static_cast<std::uint8_t>(i | kAsItIs)};
    for (const Bytes& slice : stream.slices) {
      append_part(bodies, std::span(slice).subspan(kPacketHeaderBytes));
      append_part(packets, slice);
    }
    put("slice", stream.name, bodies);
    put("slice", stream.name + "_packets", packets);
  }
  // Patches are small as they are.
  const Bytes paper = file_bytes(golden / "points_paper.plc");
  const auto contents = read_plc(paper);
  claim(contents.ok(), "points_paper.plc");
  for (const PlcFrame& frame : contents->frames) {
    for (std::size_t n = 0; n < frame.slices.size(); ++n)
      put("patch", "frame_" + std::to_string(frame.frame) + "_" + std::to_string(n),
          frame.slices[n].subspan(kPacketHeaderBytes));
  }
  for (const auto& entry : fs::directory_iterator(golden / "bad")) {
    const std::string name = entry.path().filename().string();
    if (name.find("__file_") != std::string::npos) put("file", name, file_bytes(entry.path()));
    if (name.find("__patches_") != std::string::npos) {
      const Bytes packet = file_bytes(entry.path());
      put("patch", name, std::span(packet).subspan(kPacketHeaderBytes));
    }
    if (name.find("__key_") != std::string::npos) {
      const Bytes packet = file_bytes(entry.path());
      put("key", name, std::span(packet).subspan(std::min(packet.size(), kPacketHeaderBytes)));
    }
  }
}

PointCloud cloud_of(std::uint32_t width, std::uint32_t height, double offset) {
  Pcg32 random(width);
  PointCloud cloud;
  cloud.width = width;
  cloud.height = height;
  cloud.origin_x = offset;
  for (std::uint32_t i = 0; i < width * height; ++i) {
    const auto any = [&] { return static_cast<float>(random.uniform() * 8 - 4); };
    cloud.points.push_back({any(), any(), any()});
  }
  return cloud;
}

void readers() {
  DepthImage image{8, 5, {}};
  for (std::uint32_t i = 0; i < 40; ++i)
    image.depth.push_back(static_cast<std::uint16_t>(i % 7 == 0 ? 0 : 1000 + i * i));
  claim(write_depth_png(place("depth_png", "small.png"), image).ok(), "a PNG is written");
  const PointCloud list = cloud_of(7, 1, 0), grid = cloud_of(4, 3, 0), far = cloud_of(3, 1, 4e5);
  claim(write_kitti_bin(place("kitti_bin", "list.bin"), list).ok(), "a KITTI file is written");
  for (const auto& [name, cloud] : {std::pair{"list", &list}, {"grid", &grid}, {"far", &far}}) {
    claim(write_pcd(place("pcd", name), *cloud).ok(), "a PCD is written");
    claim(write_ply(place("ply", name), *cloud).ok(), "a PLY is written");
    claim(write_xyz_text(place("xyz_text", name), *cloud).ok(), "a text is written");
  }
}

// What our writers never write.
void foreign() {
  const std::string pcd =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb _\nSIZE 4 4 4 4 1\nTYPE F F F U U\n"
      "COUNT 1 1 1 1 3\nWIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 1 1 0 0 0\nPOINTS 4\nDATA ";
  put_text("pcd", "ascii",
           pcd + "ascii\n0 1 2 9 0 0 0\nnan nan nan 9 0 0 0\n1e2 -1 .5 9 0 0 0\n3 4 5 6 7 8 9\n");
  put_text("pcd", "old",
           "VERSION .5\nFIELDS y z x\nSIZE 8 8 8\nTYPE F F F\nPOINTS 1\nDATA ascii\n1 2 3\n");
  Bytes plain(4 * 19, 0x41);
  const Bytes packed = lzf_pack(plain);
  std::string text = pcd + "binary_compressed\n";
  for (const std::size_t size : {packed.size(), plain.size()})
    for (int i = 0; i < 4; ++i) text += static_cast<char>(size >> (8 * i));
  text.append(packed.begin(), packed.end());
  put_text("pcd", "compressed", text);
  const std::string ply =
      "element vertex 2\nproperty double x\nproperty float y\nproperty short z\n"
      "property uchar red\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n";
  put_text("ply", "ascii",
           "ply\nformat ascii 1.0\ncomment c\n" + ply + "1 2 3 4\n5 6 7 8\n3 0 1 0\n");
  const std::string body(2 * 15 + 1 + 8, '\2');
  put_text("ply", "big_endian", "ply\nformat binary_big_endian 1.0\n" + ply + body);
  put_text("ply", "lists",
           "ply\nformat ascii 1.0\nelement other 1\nproperty list int float a\n" + ply +
               "2 1.5 2.5\n1 2 3 4\n5 6 7 8\n3 0 1 0\n");
  put_text("xyz_text", "header", "\xEF\xBB\xBFX;Y;Z;intensity\n1;2;3;4\n5;6;;8\n");
  put_text("xyz_text", "count", "3\n1 2 3\r\n4 5 6\r\n7e300 nan -inf # end\r\n");
  put_text("xyz_text", "comment", "// z y x\n# a\n\n1,2,3\n-4,.5,6e-2\n");
}

}  // namespace
}  // namespace planecast::test

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_corpus FOLDER\n");
    return 2;
  }
  planecast::test::root = argv[1];
  planecast::test::wire(PLANECAST_SOURCE_DIR "/tests/golden");
  planecast::test::readers();
  planecast::test::foreign();
  return 0;
}
