#include "core/base/thread_stack.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <vector>

namespace planecast {
namespace {

// An emulator in user mode does not know: there even a page just written counts as absent.
bool presence_is_known(std::byte* page, std::size_t bytes) {
  *static_cast<volatile std::byte*>(page) = std::byte{1};
  unsigned char present = 0;
  return ::mincore(page, bytes, &present) == 0 && (present & 1U) != 0;
}

TEST(ThreadStack, IsMappedWholeAndPresentAboveItsGuardPage) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  ThreadStack stack = map_stack();
  ASSERT_NE(stack.mapping, nullptr);
  EXPECT_GE(stack.usable().size(), kStackBytes);
  EXPECT_EQ(stack_mapping_bytes(), stack.usable().size() + page);
  EXPECT_EQ(stack.usable().data(), stack.mapping + page);
  std::vector<unsigned char> present(stack.usable().size() / page);
  ASSERT_EQ(::mincore(stack.usable().data(), stack.usable().size(), present.data()), 0);
  if (presence_is_known(stack.usable().data(), page)) {
    for (const unsigned char one : present) ASSERT_EQ(one & 1U, 1U);
  }
  unmap_stack(stack);
  EXPECT_EQ(stack.mapping, nullptr);
  EXPECT_TRUE(stack.usable().empty());
  unmap_stack(stack);  // nothing happens
}

TEST(ThreadStackDeathTest, RunningOverItsEndEndsTheProgramInsteadOfSpoilingOthers) {
  const ThreadStack stack = map_stack();
  ASSERT_NE(stack.mapping, nullptr);
  EXPECT_DEATH(*static_cast<volatile std::byte*>(stack.usable().data() - 1) = std::byte{1}, "");
}

}  // namespace
}  // namespace planecast
