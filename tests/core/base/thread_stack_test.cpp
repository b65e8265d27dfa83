#include "core/base/thread_stack.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <vector>

namespace planecast {
namespace {

bool all_present(std::byte* mapping, std::size_t bytes, std::size_t page) {
  std::vector<unsigned char> present(bytes / page);
  return ::mincore(mapping, bytes, present.data()) == 0 &&
         std::all_of(present.begin(), present.end(), [](unsigned char one) { return one & 1U; });
}

// An emulator maps nothing in advance; a plain mapping shows whether this machine does.
bool machine_populates(std::size_t bytes, std::size_t page) {
  void* mapping = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                         MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (mapping == MAP_FAILED) return false;
  const bool present = all_present(static_cast<std::byte*>(mapping), bytes, page);
  ::munmap(mapping, bytes);
  return present;
}

TEST(ThreadStack, IsMappedWholeAndPresentAboveItsGuardPage) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  ThreadStack stack = map_stack();
  ASSERT_NE(stack.mapping, nullptr);
  EXPECT_GE(stack.usable().size(), kStackBytes);
  EXPECT_EQ(stack_mapping_bytes(), stack.usable().size() + page);
  EXPECT_EQ(stack.usable().data(), stack.mapping + page);
  if (machine_populates(stack.usable().size(), page)) {
    EXPECT_TRUE(all_present(stack.usable().data(), stack.usable().size(), page));
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
