// One link of the chain: its pose, Jacobian and rates from the positions of all joints. All memory is made once.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "stillreach/urdf.hpp"

namespace kinematics_interface_stillreach {

class LinkModel {
 public:
  // Throws std::invalid_argument where the joints up to the link make no arm, as when one follows a joint behind it.
  LinkModel(const stillreach::UrdfChain& chain, const stillreach::UrdfLink& link, double period) : pose_(link.frame) {
    const auto end = chain.joints.begin() + static_cast<std::ptrdiff_t>(link.joints);
    std::vector<stillreach::Joint> joints(chain.joints.begin(), end);
    if (joints.empty()) return;
    arm_ = std::make_unique<stillreach::Arm>(joints, link.frame);
    stillreach::Options options;
    options.period = period;
    limited_ = std::make_unique<stillreach::Controller>(*arm_, options);
    for (stillreach::Joint& joint : joints) {
      joint.velocity_limit = joint.upper = joint.acceleration_limit = stillreach::kNoLimit;
      joint.lower = -stillreach::kNoLimit;
    }
    options.law = stillreach::bare_least_error();
    options.transition_rate = 0.0;  // no memory of the calls before
    free_ = std::make_unique<stillreach::Controller>(stillreach::Arm(joints, link.frame), options);
    jacobian_.resize(6 * n());
    rates_.resize(n());
  }

  // The first so many of all joints move the link.
  std::size_t n() const { return arm_ ? static_cast<std::size_t>(arm_->n()) : 0; }

  void set_faults(const std::vector<stillreach::Fault>& all) noexcept {
    for (std::size_t i = 0; i < n(); ++i) {
      limited_->fail(static_cast<int>(i), all[i]);
      free_->fail(static_cast<int>(i), stillreach::works(all[i]) ? stillreach::Fault{} : stillreach::locked());
    }
  }

  const stillreach::Pose& pose(const double* q) noexcept {
    if (arm_) arm_->kinematics({q, n()}, pose_);
    return pose_;
  }
  // Column after column of the joints that move the link.
  const std::vector<double>& jacobian(const double* q) noexcept {
    if (arm_) arm_->kinematics({q, n()}, pose_, jacobian_);
    return jacobian_;
  }
  // The rates for a twist: by the default law within all limits, or without limits. False for what is no number; the
  // rates are then those of a brake.
  bool rates(const double* q, const double* twist, bool limits, double* rates) noexcept {
    if (!arm_) return true;
    stillreach::Controller& law = limits ? *limited_ : *free_;
    return !(law.step({q, n()}, {twist, 6}, {rates, n()}) & stillreach::INVALID_INPUT);
  }
  // One column of the inverse: what the working joints do for a unit of one row of the twist.
  const double* inverse_column(const double* q, int row) noexcept {
    double twist[6] = {0, 0, 0, 0, 0, 0};
    twist[row] = 1.0;
    return rates(q, twist, false, rates_.data()) ? rates_.data() : nullptr;
  }

 private:
  stillreach::Pose pose_;  // of a link that no joint moves, for ever
  std::unique_ptr<stillreach::Arm> arm_;
  std::unique_ptr<stillreach::Controller> limited_, free_;
  std::vector<double> jacobian_, rates_;
};

}  // namespace kinematics_interface_stillreach
