// The kinematics_interface of ros2_control (2.4.0) on stillreach: a serial arm whose joints fail.
#include <atomic>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "faults.hpp"
#include "kinematics_interface/kinematics_interface.hpp"
#include "model.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "rclcpp/logging.hpp"
#include "rclcpp/node_interfaces/node_parameters_interface.hpp"

namespace kinematics_interface_stillreach {

using Parameters = rclcpp::node_interfaces::NodeParametersInterface;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector7 = Eigen::Matrix<double, 7, 1>;

class KinematicsInterfaceStillreach : public kinematics_interface::KinematicsInterface {
 public:
  bool initialize(const std::string& robot_description, std::shared_ptr<Parameters> parameters,
                  const std::string& param_namespace) override {
    on_set_.reset();
    after_set_.reset();
    links_.clear();
    joints_.clear();
    prefix_ = param_namespace.empty() ? "" : param_namespace + ".";
    try {
      make_links(robot_description, *parameters);
      watch_faults(*parameters);
      return true;
    } catch (const std::exception& error) {
      RCLCPP_ERROR(logger_, "%s", error.what());
    }
    links_.clear();
    joints_.clear();
    return false;
  }

  bool convert_cartesian_deltas_to_joint_deltas(const Eigen::VectorXd& joint_pos, const Vector6& delta_x,
                                                const std::string& link_name, Eigen::VectorXd& delta_theta) override {
    LinkModel* link = checked(link_name, joint_pos);
    if (!link || !has_size("delta_theta", delta_theta)) return false;
    const Vector6 twist = delta_x / period_;
    const bool valid = link->rates(joint_pos.data(), twist.data(), limits_, delta_theta.data());
    for (Eigen::Index i = 0; i < n(); ++i)
      delta_theta[i] = i < static_cast<Eigen::Index>(link->n()) ? delta_theta[i] * period_ : 0.0;
    return valid;
  }

  bool convert_joint_deltas_to_cartesian_deltas(const Eigen::VectorXd& joint_pos, const Eigen::VectorXd& delta_theta,
                                                const std::string& link_name, Vector6& delta_x) override {
    LinkModel* link = checked(link_name, joint_pos);
    if (!link || !has_size("delta_theta", delta_theta)) return false;
    const std::vector<double>& jacobian = link->jacobian(joint_pos.data());
    delta_x.setZero();
    for (std::size_t i = 0; i < link->n(); ++i)
      for (int r = 0; r < 6; ++r)
        delta_x[r] += jacobian[6 * i + static_cast<std::size_t>(r)] * delta_theta[static_cast<Eigen::Index>(i)];
    return true;
  }

  bool calculate_link_transform(const Eigen::VectorXd& joint_pos, const std::string& link_name,
                                Eigen::Isometry3d& transform) override {
    LinkModel* link = checked(link_name, joint_pos);
    if (!link) return false;
    transform.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(link->pose(joint_pos.data()).T);
    return true;
  }

  bool calculate_jacobian(const Eigen::VectorXd& joint_pos, const std::string& link_name,
                          Eigen::Matrix<double, 6, Eigen::Dynamic>& jacobian) override {
    LinkModel* link = checked(link_name, joint_pos);
    if (!link || !has_shape("jacobian", jacobian, 6, n())) return false;
    const std::vector<double>& moving = link->jacobian(joint_pos.data());
    jacobian.setZero();
    std::copy(moving.begin(), moving.end(), jacobian.data());
    return true;
  }

  bool calculate_jacobian_inverse(const Eigen::VectorXd& joint_pos, const std::string& link_name,
                                  Eigen::Matrix<double, Eigen::Dynamic, 6>& jacobian_inverse) override {
    LinkModel* link = checked(link_name, joint_pos);
    if (!link || !has_shape("jacobian_inverse", jacobian_inverse, n(), 6)) return false;
    jacobian_inverse.setZero();
    for (int row = 0; row < 6; ++row) {
      const double* column = link->inverse_column(joint_pos.data(), row);
      if (!column) return false;
      for (std::size_t i = 0; i < link->n(); ++i) jacobian_inverse(static_cast<Eigen::Index>(i), row) = column[i];
    }
    return true;
  }

  bool calculate_frame_difference(Vector7& x_a, Vector7& x_b, double dt, Vector6& delta_x) override {
    if (!(dt > 0.0) || !x_a.allFinite() || !x_b.allFinite() || x_a.tail<4>().isZero(0) || x_b.tail<4>().isZero(0)) {
      RCLCPP_ERROR(logger_, "calculate_frame_difference: got a period of %g s, expected one above 0 s, and two frames",
                   dt);
      return false;
    }
    const Eigen::Quaterniond a = Eigen::Quaterniond(x_a.tail<4>()).normalized();
    const Eigen::Quaterniond b = Eigen::Quaterniond(x_b.tail<4>()).normalized();
    const Eigen::AngleAxisd turn(b * a.conjugate());
    delta_x.head<3>() = (x_b.head<3>() - x_a.head<3>()) / dt;
    delta_x.tail<3>() = turn.axis() * (turn.angle() / dt);
    return true;
  }

 private:
  template <class T>
  rclcpp::Parameter parameter(Parameters& parameters, const std::string& name, const T& otherwise) const {
    if (!parameters.has_parameter(prefix_ + name))
      parameters.declare_parameter(prefix_ + name, rclcpp::ParameterValue(otherwise));
    rclcpp::Parameter value;
    parameters.get_parameter(prefix_ + name, value);
    return value;
  }

  void make_links(std::string text, Parameters& parameters) {
    rclcpp::Parameter description;
    if (text.empty() && parameters.get_parameter("robot_description", description)) text = description.as_string();
    if (text.empty()) throw std::invalid_argument("robot_description: got none, expected the text of a URDF file");
    const std::string tip = parameter(parameters, "tip", std::string()).as_string();
    const std::string base = parameter(parameters, "base", std::string()).as_string();
    period_ = parameter(parameters, "period", 0.01).as_double();
    limits_ = parameter(parameters, "limits", true).as_bool();
    if (!(period_ > 0.0 && std::isfinite(period_))) throw std::invalid_argument("period: expected a time above 0 s");
    if (tip.empty()) throw std::invalid_argument("tip: got none, expected the name of a link");
    const stillreach::UrdfChain chain = stillreach::read_urdf(text, tip, base);
    for (const stillreach::Joint& joint : chain.joints)
      if (joint.follows.empty()) joints_.push_back(joint.name);
    for (const stillreach::UrdfLink& link : chain.links) try {
        links_.emplace(link.name, LinkModel(chain, link, period_));
      } catch (const std::invalid_argument& error) {
        if (link.name == tip) throw;
        RCLCPP_WARN(logger_, "link %s is left out: %s", link.name.c_str(), error.what());
      }
  }

  // Faults follow the parameters: checked before they are set, and taken by the next conversion.
  void watch_faults(Parameters& parameters) {
    const std::vector<std::string> none;
    names_ = parameter(parameters, "failed_joints", none).as_string_array();
    kinds_ = parameter(parameters, "failed_kinds", none).as_string_array();
    faults_ = read_faults(joints_, names_, kinds_);
    changed_.store(true);
    on_set_ = parameters.add_on_set_parameters_callback([this](const std::vector<rclcpp::Parameter>& set) {
      rcl_interfaces::msg::SetParametersResult result;
      result.successful = true;
      try {
        std::vector<std::string> names = names_, kinds = kinds_;
        if (choose(set, names, kinds)) read_faults(joints_, names, kinds);
      } catch (const std::exception& error) {
        result.successful = false;
        result.reason = error.what();
      }
      return result;
    });
    after_set_ = parameters.add_post_set_parameters_callback([this](const std::vector<rclcpp::Parameter>& set) {
      if (!choose(set, names_, kinds_)) return;
      const std::vector<stillreach::Fault> faults = read_faults(joints_, names_, kinds_);
      const std::lock_guard<std::mutex> lock(mutex_);
      faults_ = faults;
      changed_.store(true);
    });
  }

  // Whether one of the parameters is about faults; their values then.
  bool choose(const std::vector<rclcpp::Parameter>& set, std::vector<std::string>& names,
              std::vector<std::string>& kinds) const {
    bool ours = false;
    for (const rclcpp::Parameter& one : set) {
      const bool joints = one.get_name() == prefix_ + "failed_joints";
      if (!joints && one.get_name() != prefix_ + "failed_kinds") continue;
      (joints ? names : kinds) = one.as_string_array();
      ours = true;
    }
    return ours;
  }

  // Takes over changed faults, unless another thread is just writing them: then the next call does. Never waits.
  void take_faults() noexcept {
    if (!changed_.load()) return;
    const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
    if (!lock.owns_lock()) return;
    for (auto& [name, link] : links_) link.set_faults(faults_);
    changed_.store(false);
  }

  Eigen::Index n() const { return static_cast<Eigen::Index>(joints_.size()); }

  LinkModel* checked(const std::string& link_name, const Eigen::VectorXd& joint_pos) {
    if (joints_.empty()) {
      RCLCPP_ERROR(logger_, "initialize() was not called, or failed");
      return nullptr;
    }
    const auto found = links_.find(link_name);
    if (found == links_.end()) {
      RCLCPP_ERROR(logger_, "link_name: got '%s', expected a link between base and tip", link_name.c_str());
      return nullptr;
    }
    if (!has_size("joint_pos", joint_pos)) return nullptr;
    take_faults();
    return &found->second;
  }
  bool has_size(const char* what, const Eigen::VectorXd& vector) const { return has_shape(what, vector, n(), 1); }
  template <class Matrix>
  bool has_shape(const char* what, const Matrix& matrix, Eigen::Index rows, Eigen::Index columns) const {
    if (matrix.rows() == rows && matrix.cols() == columns) return true;
    RCLCPP_ERROR(logger_, "%s: got the size %ld x %ld, expected %ld x %ld", what, static_cast<long>(matrix.rows()),
                 static_cast<long>(matrix.cols()), static_cast<long>(rows), static_cast<long>(columns));
    return false;
  }

  rclcpp::Logger logger_ = rclcpp::get_logger("kinematics_interface_stillreach");
  std::string prefix_;
  double period_ = 0.01;
  bool limits_ = true;
  std::vector<std::string> joints_;  // from base to tip, those that follow others left out
  std::map<std::string, LinkModel> links_;
  std::vector<std::string> names_, kinds_;  // of the thread that sets parameters
  std::mutex mutex_;
  std::vector<stillreach::Fault> faults_;  // with the mutex
  std::atomic<bool> changed_{false};
  rclcpp::node_interfaces::OnSetParametersCallbackHandle::SharedPtr on_set_;
  rclcpp::node_interfaces::PostSetParametersCallbackHandle::SharedPtr after_set_;
};

}  // namespace kinematics_interface_stillreach

PLUGINLIB_EXPORT_CLASS(kinematics_interface_stillreach::KinematicsInterfaceStillreach,
                       kinematics_interface::KinematicsInterface)
