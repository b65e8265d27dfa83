#include "transport/lcm_url.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace planecast {
namespace {

/// Sets an environment variable for the length of a scope.
class ScopedEnv {
 public:
  ScopedEnv(const char* name, const char* value) : name_(name) {
    const char* old = std::getenv(name);
    if (old != nullptr) old_ = old;
    had_ = old != nullptr;
    ::setenv(name, value, 1);
  }
  ~ScopedEnv() { had_ ? ::setenv(name_, old_.c_str(), 1) : ::unsetenv(name_); }

 private:
  const char* name_;
  std::string old_;
  bool had_ = false;
};

std::string mistake_of(std::string_view url) {
  const Result<LcmUrl> result = parse_lcm_url(url);
  EXPECT_FALSE(result.ok()) << url;
  if (result.ok()) return {};
  EXPECT_EQ(result.error().status, Status::kUsage);
  return result.error().message;
}

}  // namespace

TEST(LcmUrl, FillsDefaults) {
  for (const std::string_view text : {"", "udpm://", "udpm://239.255.76.67:7667"}) {
    const Result<LcmUrl> url = parse_lcm_url(text);
    ASSERT_TRUE(url.ok()) << text;
    EXPECT_EQ(to_string(*url), kDefaultLcmUrl);
  }
}

TEST(LcmUrl, ReadsEveryPart) {
  const Result<LcmUrl> url = parse_lcm_url("udpm://239.1.2.3:5000?recv_buf_size=300000&ttl=32");
  ASSERT_TRUE(url.ok());
  EXPECT_EQ(url->group, "239.1.2.3");
  EXPECT_EQ(url->port, 5000);
  EXPECT_EQ(url->ttl, 32);
  EXPECT_EQ(url->receive_buffer_bytes, 300'000U);
  EXPECT_EQ(to_string(*url), "udpm://239.1.2.3:5000?ttl=32&recv_buf_size=300000");
}

TEST(LcmUrl, WrittenFormReadsBackTheSame) {
  for (const std::string_view text : {"memq://", "udpm://224.0.0.0:1?ttl=1",
                                      "udpm://239.255.255.255:65535?ttl=0", "udpm://?ttl=3"}) {
    const Result<LcmUrl> url = parse_lcm_url(text);
    ASSERT_TRUE(url.ok()) << text;
    const Result<LcmUrl> again = parse_lcm_url(to_string(*url));
    ASSERT_TRUE(again.ok()) << to_string(*url);
    EXPECT_EQ(to_string(*again), to_string(*url));
  }
}

TEST(LcmUrl, AReceiverAsksForABufferUnlessTheUrlNamesOne) {
  const std::uint32_t granted = granted_receive_buffer_bytes();
  if (granted == 0) GTEST_SKIP() << "rmem_max cannot be read here";
  EXPECT_NE(to_string(LcmUrl{}, true).find("recv_buf_size="), std::string::npos);
  LcmUrl own;
  own.receive_buffer_bytes = 8192;
  EXPECT_NE(to_string(own, true).find("recv_buf_size=8192"), std::string::npos);
}

TEST(LcmUrl, RefusesWhatLiblcmWouldBend) {
  EXPECT_NE(mistake_of("udpm://239.255.76.67:7667?ttl=300").find("0 (this host only) to 32"),
            std::string::npos);
  EXPECT_NE(mistake_of("udpm://239.255.76.67").find("port is missing"), std::string::npos);
  for (const std::string_view port : {"0", "65536", "", "7667x", "-1", "+1", "0x1", "00"})
    EXPECT_NE(mistake_of("udpm://239.255.76.67:" + std::string(port)).find("1 to 65535"),
              std::string::npos)
        << port;
  for (const std::string_view group : {"192.168.0.1", "223.255.255.255", "240.0.0.0"})
    EXPECT_NE(mistake_of("udpm://" + std::string(group) + ":1").find("not a multicast address"),
              std::string::npos)
        << group;
  for (const std::string_view group : {"239.255.76", "localhost", "239.255.76.256", "239.1.1.1 "})
    EXPECT_NE(mistake_of("udpm://" + std::string(group) + ":1").find("not an IPv4 address"),
              std::string::npos)
        << group;
  for (const std::string_view ttl : {"", "-1", "33", "1.5", "four"})
    EXPECT_NE(mistake_of("udpm://239.1.1.1:1?ttl=" + std::string(ttl)).find("ttl"),
              std::string::npos)
        << ttl;
  (void)mistake_of("udpm://239.1.1.1:1?recv_buf_size=10");
  (void)mistake_of("udpm:/239.1.1.1:1");
  (void)mistake_of("tcpq://127.0.0.1:7700");
  (void)mistake_of("memq://something");
}

TEST(LcmUrl, UnknownOptionNamesTheNearest) {
  EXPECT_NE(mistake_of("udpm://239.1.1.1:1?tll=1").find("'tll', the nearest is 'ttl'"),
            std::string::npos);
  EXPECT_NE(mistake_of("udpm://239.1.1.1:1?ttl=1,recv_buffer_size=9000")
                .find("nearest is 'recv_buf_size'"),
            std::string::npos);
}

TEST(LcmUrl, EnvironmentIsHonoured) {
  {
    const ScopedEnv env("LCM_DEFAULT_URL", "udpm://239.9.9.9:999");
    const Result<LcmUrl> url = default_lcm_url();
    ASSERT_TRUE(url.ok());
    EXPECT_EQ(url->group, "239.9.9.9");
  }
  {
    const ScopedEnv env("LCM_DEFAULT_URL", "nonsense");
    EXPECT_FALSE(default_lcm_url().ok());
  }
  const ScopedEnv env("LCM_DEFAULT_URL", "");
  ASSERT_TRUE(default_lcm_url().ok());
  EXPECT_EQ(to_string(*default_lcm_url()), kDefaultLcmUrl);
}

TEST(LcmUrl, MemoryQueueNeedsNoRoute) {
  const Result<LcmUrl> url = parse_lcm_url("memq://");
  ASSERT_TRUE(url.ok());
  EXPECT_TRUE(check_multicast_route(*url).ok());
  EXPECT_EQ(path_mtu_bytes(*url), 0U);
}

}  // namespace planecast
