#include "apps/common/live_line.hpp"

#include <gtest/gtest.h>

#include <string>

namespace planecast {
namespace {

using std::chrono::milliseconds;

/// A stream that is no terminal, and what was written to it.
class Sink {
 public:
  Sink() : file_(std::tmpfile()) {}
  ~Sink() { std::fclose(file_); }
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  std::FILE* file() { return file_; }
  std::string text() {
    std::rewind(file_);
    std::string out;
    for (int c = std::fgetc(file_); c != EOF; c = std::fgetc(file_)) out += static_cast<char>(c);
    return out;
  }

 private:
  std::FILE* file_;
};

TEST(LiveLine, IsDueAtOnceAndThenOncePerPeriod) {
  Sink sink;
  LiveLine line(sink.file());
  const LiveLine::Clock::time_point start{};
  EXPECT_TRUE(line.due(start));
  line.print("a", start);
  EXPECT_FALSE(line.due(start + milliseconds(999)));
  EXPECT_TRUE(line.due(start + milliseconds(1000)));
}

TEST(LiveLine, KeepsTheBeatWhenALineComesLate) {
  Sink sink;
  LiveLine line(sink.file());
  const LiveLine::Clock::time_point start{};
  line.print("a", start);
  line.print("b", start + milliseconds(1300));
  EXPECT_FALSE(line.due(start + milliseconds(1999)));
  EXPECT_TRUE(line.due(start + milliseconds(2000)));
  line.print("c", start + milliseconds(9500));  // after a long pause the beat starts anew
  EXPECT_FALSE(line.due(start + milliseconds(10000)));
  EXPECT_TRUE(line.due(start + milliseconds(10500)));
}

TEST(LiveLine, InALogEveryLineIsALineWithoutControlCodes) {
  Sink sink;
  {
    LiveLine line(sink.file(), LiveLine::Style::kReplace);
    line.print("one");
    line.print("two");
    line.finish();
  }
  EXPECT_EQ(sink.text(), "one\ntwo\n");
}

TEST(CutToColumns, CountsCharactersNotBytes) {
  EXPECT_EQ(cut_to_columns("abcdef", 3), "abc");
  EXPECT_EQ(cut_to_columns("abc", 9), "abc");
  EXPECT_EQ(cut_to_columns("\u03c3\u03c3\u03c3", 2), "\u03c3\u03c3");
  EXPECT_EQ(cut_to_columns("abc", 0), "");
}

TEST(HumanBytes, HasThreeFiguresAndTheRightUnit) {
  EXPECT_EQ(human_bytes(0), "0 B");
  EXPECT_EQ(human_bytes(812), "812 B");
  EXPECT_EQ(human_bytes(999.6), "1.00 kB");
  EXPECT_EQ(human_bytes(1200), "1.20 kB");
  EXPECT_EQ(human_bytes(41300), "41.3 kB");
  EXPECT_EQ(human_bytes(99960), "100 kB");
  EXPECT_EQ(human_bytes(3686400), "3.69 MB");
}

TEST(WithThousands, GroupsByThree) {
  EXPECT_EQ(with_thousands(0), "0");
  EXPECT_EQ(with_thousands(999), "999");
  EXPECT_EQ(with_thousands(1000), "1,000");
  EXPECT_EQ(with_thousands(1234567), "1,234,567");
}

}  // namespace
}  // namespace planecast
