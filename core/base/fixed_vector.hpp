// A span and a size: a vector that never grows past the memory it was given and never allocates.
// A full one says so by a bool; the stage turns that into a Status.
#pragma once

#include <cassert>
#include <cstddef>
#include <span>
#include <type_traits>

namespace planecast {

/// Up to capacity() objects in memory owned by someone else (usually an Arena), which must outlive
/// it. Copying is refused: two vectors over one memory would disagree on the size. One thread at a
/// time. No call allocates; all are O(1) but resize().
template <class T>
class FixedVector {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  FixedVector() noexcept = default;
  explicit FixedVector(std::span<T> memory) noexcept : memory_(memory) {}
  FixedVector(const FixedVector&) = delete;
  FixedVector& operator=(const FixedVector&) = delete;
  FixedVector(FixedVector&& other) noexcept : memory_(other.memory_), size_(other.size_) {
    other.forget();
  }
  FixedVector& operator=(FixedVector&& other) noexcept {
    if (this == &other) return *this;
    memory_ = other.memory_;
    size_ = other.size_;
    other.forget();
    return *this;
  }

  /// Appends; false, with nothing changed, when full.
  [[nodiscard]] bool push_back(const T& value) noexcept {
    if (full()) return false;
    memory_[size_++] = value;
    return true;
  }

  /// Appends all of `values` (which may not overlap the memory) or none; false when they do not
  /// fit.
  [[nodiscard]] bool append(std::span<const T> values) noexcept {
    if (values.size() > capacity() - size_) return false;
    for (const T& value : values) memory_[size_++] = value;
    return true;
  }

  /// Sets the size; new elements are value-initialised. False, with nothing changed, past
  /// capacity().
  [[nodiscard]] bool resize(std::size_t n) noexcept {
    if (n > capacity()) return false;
    for (; size_ < n; ++size_) memory_[size_] = T{};
    size_ = n;
    return true;
  }

  /// Removes the last element; the vector may not be empty.
  void pop_back() noexcept {
    assert(size_ > 0);
    --size_;
  }

  void clear() noexcept { size_ = 0; }

  std::size_t size() const noexcept { return size_; }
  std::size_t capacity() const noexcept { return memory_.size(); }
  bool empty() const noexcept { return size_ == 0; }
  bool full() const noexcept { return size_ == memory_.size(); }

  T& operator[](std::size_t i) noexcept {
    assert(i < size_);
    return memory_[i];
  }
  const T& operator[](std::size_t i) const noexcept {
    assert(i < size_);
    return memory_[i];
  }
  T& back() noexcept { return (*this)[size_ - 1]; }
  const T& back() const noexcept { return (*this)[size_ - 1]; }

  T* data() noexcept { return memory_.data(); }
  const T* data() const noexcept { return memory_.data(); }
  T* begin() noexcept { return data(); }
  T* end() noexcept { return data() + size_; }
  const T* begin() const noexcept { return data(); }
  const T* end() const noexcept { return data() + size_; }

  /// The elements in use.
  std::span<T> view() noexcept { return memory_.first(size_); }
  std::span<const T> view() const noexcept { return memory_.first(size_); }

 private:
  void forget() noexcept {
    memory_ = {};
    size_ = 0;
  }

  std::span<T> memory_;
  std::size_t size_ = 0;
};

}  // namespace planecast
