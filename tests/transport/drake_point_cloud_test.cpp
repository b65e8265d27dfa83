#include "transport/drake_point_cloud.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "core/base/random.hpp"
#include "drake/lcmt_point_cloud.hpp"

namespace planecast {
namespace {

constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();
const float kNaN = std::numeric_limits<float>::quiet_NaN();

std::vector<float> random_cloud(std::size_t points, std::uint64_t seed) {
  Pcg32 random(seed);
  std::vector<float> xyz(points * 3);
  for (float& value : xyz) value = static_cast<float>(random.uniform() * 10 - 5);
  return xyz;
}

std::vector<std::uint8_t> encoded(const std::vector<float>& xyz, std::string_view name,
                                  std::size_t max_points = kNoLimit) {
  std::vector<std::uint8_t> out(drake_point_cloud_bytes(xyz.size() / 3, name));
  std::size_t size = 0;
  EXPECT_EQ(encode_drake_point_cloud(1'234'567, name, xyz, max_points, out, size), Status::kOk);
  out.resize(size);
  return out;
}

drake::lcmt_point_cloud reference_cloud(const std::vector<float>& xyz, const std::string& name) {
  drake::lcmt_point_cloud cloud;
  cloud.utime = 1'234'567;
  cloud.frame_name = name;
  cloud.width = static_cast<std::int64_t>(xyz.size() / 3);
  cloud.height = 1;
  cloud.num_fields = 3;
  cloud.fields.resize(3);
  for (std::size_t i = 0; i < 3; ++i) {
    cloud.fields[i].name = std::string(1, "xyz"[i]);
    cloud.fields[i].byte_offset = static_cast<std::int32_t>(4 * i);
    cloud.fields[i].datatype = drake::lcmt_point_cloud_field::FLOAT32;
    cloud.fields[i].count = 1;
  }
  cloud.flags = 2;
  cloud.point_step = 12;
  cloud.row_step = cloud.width * 12;
  cloud.filler_size = 0;
  cloud.data_size = cloud.row_step;
  cloud.data.resize(xyz.size() * 4);
  if (!xyz.empty()) std::memcpy(cloud.data.data(), xyz.data(), cloud.data.size());
  return cloud;
}

std::vector<std::uint8_t> encoded_by_lcm(const drake::lcmt_point_cloud& cloud) {
  std::vector<std::uint8_t> message(static_cast<std::size_t>(cloud.getEncodedSize()));
  EXPECT_EQ(cloud.encode(message.data(), 0, static_cast<int>(message.size())),
            static_cast<int>(message.size()));
  return message;
}

/// An organised cloud with further fields, padding and filler, as a camera driver would send it.
drake::lcmt_point_cloud organised_cloud() {
  drake::lcmt_point_cloud cloud = reference_cloud({}, "camera");
  cloud.flags = 0;
  cloud.width = 5;
  cloud.height = 3;
  cloud.point_step = 24;
  cloud.row_step = 5 * 24 + 8;
  cloud.num_fields = 4;
  cloud.fields.resize(4);
  cloud.fields[3].name = "rgb";
  cloud.fields[3].byte_offset = 0;
  cloud.fields[3].datatype = drake::lcmt_point_cloud_field::UINT32;
  cloud.fields[3].count = 1;
  cloud.fields[0].byte_offset = 16;
  cloud.fields[1].byte_offset = 8;
  cloud.fields[2].byte_offset = 4;
  cloud.filler_size = 3;
  cloud.filler = {9, 9, 9};
  cloud.data.resize(static_cast<std::size_t>(3 * cloud.row_step));
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 5; ++column) {
      const float value = static_cast<float>(row * 10 + column);
      const float z = row == 1 && column == 2 ? kNaN : -value;
      std::uint8_t* at = &cloud.data[static_cast<std::size_t>(row * cloud.row_step + column * 24)];
      std::memcpy(at + 16, &value, 4);
      std::memcpy(at + 4, &z, 4);
      std::memset(at + 8, 0, 4);
    }
  }
  cloud.data_size = static_cast<std::int64_t>(cloud.data.size());
  return cloud;
}

Status decode(const std::vector<std::uint8_t>& message, DrakePointCloud& out,
              std::size_t max_points = 1'000'000) {
  return decode_drake_point_cloud(message, max_points, out);
}

Status decode_changed(void (*change)(drake::lcmt_point_cloud&)) {
  drake::lcmt_point_cloud cloud = organised_cloud();
  change(cloud);
  DrakePointCloud out;
  return decode(encoded_by_lcm(cloud), out);
}

}  // namespace

TEST(DrakePointCloud, FingerprintIsTheViewersOwn) {
  EXPECT_EQ(static_cast<std::uint64_t>(drake::lcmt_point_cloud::getHash()),
            kDrakePointCloudFingerprint);
}

TEST(DrakePointCloud, BytesEqualLcmGens) {
  for (const std::size_t points : {0UL, 1UL, 2UL, 5400UL, 20'000UL}) {
    for (const std::string name : {"", "world", "camera_optical"}) {
      const std::vector<float> xyz = random_cloud(points, points);
      EXPECT_EQ(encoded(xyz, name), encoded_by_lcm(reference_cloud(xyz, name))) << points;
    }
  }
}

TEST(DrakePointCloud, TheDefaultLimitFitsOneDatagramWhateverTheNames) {
  const std::string longest_name(kDrakeMaxFrameName, 'n');
  const std::string longest_channel(kMaxChannelBytes, 'c');
  EXPECT_LE(drake_point_cloud_bytes(kDrakeDatagramPoints, longest_name),
            max_datagram_message_bytes(longest_channel));
}

TEST(DrakePointCloud, PointsThatAreNotFiniteAreLeftOut) {
  std::vector<float> xyz = random_cloud(6, 1);
  xyz[0] = kNaN;
  xyz[7] = std::numeric_limits<float>::infinity();
  xyz[17] = -std::numeric_limits<float>::infinity();
  std::vector<float> finite(xyz.begin() + 3, xyz.begin() + 6);
  finite.insert(finite.end(), xyz.begin() + 9, xyz.begin() + 15);
  EXPECT_EQ(encoded(xyz, "w"), encoded_by_lcm(reference_cloud(finite, "w")));
}

TEST(DrakePointCloud, ThinningKeepsExactlyTheLimitEvenlySpread) {
  std::vector<float> xyz;
  for (int i = 0; i < 10'000; ++i) {
    const auto value = static_cast<float>(i);
    xyz.insert(xyz.end(), {value, i % 7 == 0 ? kNaN : 0.0F, 0.0F});
  }
  DrakePointCloud cloud;
  const std::vector<std::uint8_t> message = encoded(xyz, "w", 1000);
  ASSERT_EQ(decode(message, cloud), Status::kOk);
  ASSERT_EQ(cloud.width, 1000U);
  float last = -1;
  for (std::uint32_t i = 0; i < cloud.width; ++i) {
    float point[3];
    cloud.point(0, i, point);
    EXPECT_GT(point[0], last);
    EXPECT_NEAR(point[0], (static_cast<float>(i) + 0.5F) * 10, 14);
    last = point[0];
  }
}

TEST(DrakePointCloud, EncoderRefusesWhatDoesNotFit) {
  const std::vector<float> xyz = random_cloud(10, 2);
  std::vector<std::uint8_t> out(drake_point_cloud_bytes(10, "w") - 1);
  std::size_t size = 0;
  EXPECT_EQ(encode_drake_point_cloud(0, "w", xyz, kNoLimit, out, size), Status::kTooLarge);
  EXPECT_EQ(encode_drake_point_cloud(0, "w", xyz, 9, out, size), Status::kOk);
  EXPECT_EQ(encode_drake_point_cloud(0, "w", std::span(xyz).first(29), 9, out, size),
            Status::kFieldRange);
  EXPECT_EQ(encode_drake_point_cloud(0, std::string(256, 'n'), xyz, 1, out, size),
            Status::kFieldRange);
}

TEST(DrakePointCloud, OrganisedCloudStaysOrganisedWithFieldsAtAnyOffset) {
  const std::vector<std::uint8_t> message = encoded_by_lcm(organised_cloud());
  DrakePointCloud cloud;
  ASSERT_EQ(decode(message, cloud), Status::kOk);
  EXPECT_EQ(cloud.width, 5U);
  EXPECT_EQ(cloud.height, 3U);
  EXPECT_EQ(cloud.frame_name, "camera");
  EXPECT_EQ(cloud.utime, 1'234'567);
  EXPECT_FALSE(cloud.strictly_finite);
  for (std::uint32_t row = 0; row < 3; ++row) {
    for (std::uint32_t column = 0; column < 5; ++column) {
      float point[3];
      cloud.point(row, column, point);
      EXPECT_EQ(point[0], static_cast<float>(row * 10 + column));
      EXPECT_EQ(point[1], 0.0F);
      if (row == 1 && column == 2) {
        EXPECT_TRUE(std::isnan(point[2]));
      } else {
        EXPECT_EQ(point[2], -point[0]);
      }
    }
  }
}

TEST(DrakePointCloud, EveryTruncationIsRefused) {
  const std::vector<std::uint8_t> message = encoded_by_lcm(organised_cloud());
  for (std::size_t size = 0; size < message.size(); ++size) {
    const std::vector<std::uint8_t> cut(message.begin(),
                                        message.begin() + static_cast<std::ptrdiff_t>(size));
    DrakePointCloud cloud;
    EXPECT_EQ(decode(cut, cloud), Status::kTruncated) << size;
    EXPECT_EQ(cloud.points(), 0U);
  }
  std::vector<std::uint8_t> longer = message;
  longer.push_back(1);
  DrakePointCloud cloud;
  EXPECT_EQ(decode(longer, cloud), Status::kTrailingBytes);
}

TEST(DrakePointCloud, NoBitFlipLeadsOutsideTheMessage) {
  const std::vector<std::uint8_t> message = encoded_by_lcm(organised_cloud());
  for (std::size_t bit = 0; bit < message.size() * 8; ++bit) {
    std::vector<std::uint8_t> flipped = message;
    flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ (1U << (bit % 8)));
    DrakePointCloud cloud;
    if (decode(flipped, cloud) != Status::kOk) continue;
    ASSERT_LE(cloud.points(), 1'000'000U);
    for (std::uint32_t row = 0; row < cloud.height; ++row) {
      for (std::uint32_t column = 0; column < cloud.width; ++column) {
        float point[3];
        cloud.point(row, column, point);
        const auto* first = cloud.data.data() + row * cloud.row_step + column * cloud.point_step;
        for (const std::uint32_t offset : cloud.offset)
          ASSERT_LE(first + offset + 4, flipped.data() + flipped.size()) << bit;
      }
    }
  }
}

TEST(DrakePointCloud, ContradictionsAreNamed) {
  using Cloud = drake::lcmt_point_cloud;
  EXPECT_EQ(decode_changed([](Cloud&) {}), Status::kOk);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.flags = 1; }), Status::kUnsupportedVersion);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.flags = 4; }), Status::kReservedBits);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.fields[2].name = "w"; }), Status::kUnsupportedVersion);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.fields[2].datatype = 8; }),
            Status::kUnsupportedVersion);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.fields[2].count = 2; }), Status::kUnsupportedVersion);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.fields[0].byte_offset = 21; }), Status::kFieldRange);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.fields[0].byte_offset = -4; }), Status::kFieldRange);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.point_step = 26; }), Status::kFieldRange);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.point_step = 0; }), Status::kFieldRange);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.row_step = 119; }), Status::kFieldRange);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.row_step = 200; }), Status::kFieldRange);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.row_step = -1; }), Status::kFieldRange);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.height = 4; }), Status::kFieldRange);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.height = -1; }), Status::kTooLarge);
  EXPECT_EQ(decode_changed([](Cloud& c) { c.width = std::int64_t{1} << 40; }), Status::kTooLarge);
  EXPECT_EQ(decode_changed([](Cloud& c) {
              c.width = std::int64_t{1} << 33;
              c.height = std::int64_t{1} << 33;
            }),
            Status::kTooLarge);
}

TEST(DrakePointCloud, AnotherTypeIsRefused) {
  std::vector<std::uint8_t> message = encoded_by_lcm(organised_cloud());
  message[3] ^= 1;
  DrakePointCloud cloud;
  EXPECT_EQ(decode(message, cloud), Status::kBadMagic);
}

TEST(DrakePointCloud, CloudsOverTheReceiversLimitAreRefused) {
  DrakePointCloud cloud;
  const std::vector<std::uint8_t> message = encoded_by_lcm(organised_cloud());
  EXPECT_EQ(decode(message, cloud, 15), Status::kOk);
  EXPECT_EQ(decode(message, cloud, 14), Status::kTooLarge);
}

}  // namespace planecast
