#include "apps/common/realtime.hpp"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include "apps/common/memory_fit.hpp"

namespace planecast {
namespace {

TEST(ParseBytes, TakesPlainNumbersAndPowersOf1024) {
  EXPECT_EQ(parse_bytes("1").value(), 1U);
  EXPECT_EQ(parse_bytes("24000000").value(), 24'000'000U);
  EXPECT_EQ(parse_bytes("3K").value(), 3072U);
  EXPECT_EQ(parse_bytes("64MiB").value(), 64U << 20U);
  EXPECT_EQ(parse_bytes("2G").value(), std::uint64_t{2} << 30U);
}

TEST(ParseBytes, RefusesWhatIsNoSizeAndShowsAGoodOne) {
  for (const char* text : {"", "0", "0M", "-1", "1.5G", "64 MiB", "64mb", "M", "99999999999999G",
                           "18446744073709551616"}) {
    const auto bytes = parse_bytes(text);
    ASSERT_FALSE(bytes.ok()) << text;
    EXPECT_EQ(bytes.error().status, Status::kUsage);
    EXPECT_NE(bytes.error().message.find("64MiB"), std::string::npos) << bytes.error().message;
  }
}

TEST(RealtimeOptions, AreReadFromTheCommandLine) {
  CLI::App app;
  RealtimeOptions options;
  add_realtime_options(app, options);
  app.parse("--mlock --fifo 20 --first-core 1 --watchdog-ms 2.5 --memory-limit 24M", false);
  EXPECT_TRUE(options.lock_memory);
  EXPECT_EQ(options.fifo_priority, 20);
  EXPECT_EQ(options.first_core, 1);
  EXPECT_EQ(options.watchdog_ns(), 2'500'000);
  EXPECT_EQ(options.memory_limit, 24U << 20U);
  for (const char* wrong :
       {"--fifo 0", "--fifo 100", "--first-core -1", "--watchdog-ms 0", "--memory-limit 24Mb"})
    EXPECT_THROW(app.parse(wrong, false), CLI::ParseError) << wrong;
}

TEST(MemoryFit, RefusesWithTheFigureWhatStandsAgainstItAndTheMend) {
  const auto message = [](std::uint64_t limit, const MemoryRoom& room) {
    const auto fits = check_memory_fits(1000, limit, room, "take less");
    return fits.ok() ? std::string() : fits.error().message;
  };
  EXPECT_EQ(message(0, {}), "");
  EXPECT_EQ(message(1000, {1000, 1000, 1000}), "");
  EXPECT_EQ(message(999, {}),
            "frames and stacks need 1000 bytes, --memory-limit allows 999; take less");
  EXPECT_NE(message(0, {.address_space = 999}).find("RLIMIT_AS (ulimit -v) leaves 999"),
            std::string::npos);
  EXPECT_NE(message(0, {.group = 5}).find("memory.max leaves 5"), std::string::npos);
  EXPECT_NE(message(0, {.machine = 7}).find("the machine has 7 available"), std::string::npos);
}

TEST(MemoryFit, TheRoomOfThisMachineHoldsAtLeastAPage) {
  const MemoryRoom room = memory_room();
  EXPECT_GT(room.machine, 4096U);
  EXPECT_GT(room.group, 4096U);
  EXPECT_GT(room.address_space, 4096U);
  EXPECT_GT(resident_bytes(), 1U << 20U);
}

}  // namespace
}  // namespace planecast
