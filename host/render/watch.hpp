// How an observer sees what the stages of a render leave behind. `regulus check` is one.
#pragma once

#include "interface/wavefront.h"
#include "render/stages.hpp"
#include "render/work_queue.hpp"

namespace regulus::render {

/// Is told before and after each stage of a pass has run; nothing is in flight then. With several material
/// classes a stage has run for all of them.
class StageObserver {
 public:
  virtual ~StageObserver() = default;
  virtual void before(Pass pass, Stage stage, const interface::StageArguments& arguments) = 0;
  virtual void after(Pass pass, Stage stage, const interface::StageArguments& arguments) = 0;
};

/// The parts of a render tell it what they do. It passes that on to the observer, if there is one.
class Watch {
 public:
  /// `work` must outlive the object.
  explicit Watch(WorkQueue& work) : work_(work) {}

  /// Null: nobody watches any more.
  void set_observer(StageObserver* observer) { observer_ = observer; }
  bool is_on() const { return observer_ != nullptr; }

  void before(Pass pass, Stage stage, const interface::StageArguments& arguments) const {
    if (observer_ == nullptr) return;
    work_.finish();
    observer_->before(pass, stage, arguments);
  }
  void after(Pass pass, Stage stage, const interface::StageArguments& arguments) const {
    if (observer_ == nullptr) return;
    work_.finish();
    observer_->after(pass, stage, arguments);
  }

 private:
  WorkQueue& work_;
  StageObserver* observer_ = nullptr;
};

}  // namespace regulus::render
