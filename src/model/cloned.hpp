#pragma once

#include <memory>
#include <utility>

namespace battery_sof {

/// A T of its own, of a kind known at run time: copied by T::clone(). Never empty but when moved
/// from.
template <typename T>
class Cloned {
 public:
  Cloned(std::unique_ptr<T> own) : own_(std::move(own)) {}  // NOLINT(google-explicit-constructor)
  Cloned(const Cloned& other) : own_(other.own_->clone()) {}
  Cloned(Cloned&&) noexcept = default;
  Cloned& operator=(Cloned other) noexcept {
    own_ = std::move(other.own_);
    return *this;
  }
  ~Cloned() = default;
  T& operator*() const { return *own_; }
  T* operator->() const { return own_.get(); }

 private:
  std::unique_ptr<T> own_;
};

/// What is worth keeping between two calls and says nothing: a copy begins with a fresh one.
template <typename T>
class WorkSpace {
 public:
  WorkSpace() = default;
  WorkSpace(const WorkSpace&) : own_() {}
  WorkSpace(WorkSpace&&) noexcept = default;
  WorkSpace& operator=(WorkSpace other) noexcept {
    own_ = std::move(other.own_);
    return *this;
  }
  ~WorkSpace() = default;
  T& operator*() { return own_; }
  T* operator->() { return &own_; }

 private:
  T own_;
};

}  // namespace battery_sof
