// Loads the plugin by its name with pluginlib and calls it: a line of standard input is a call, with a line of answer.
// Fields are separated by tabs. Numbers are whole vectors; the answer is 1 or 0, the times that the call took memory
// from the heap, and the numbers that it gave.
#include <fstream>
#include <iostream>
#include <map>
#include <pluginlib/class_loader.hpp>
#include <sstream>

#include "heap.hpp"
#include "kinematics_interface/kinematics_interface.hpp"

namespace {

using Strings = std::vector<std::string>;

// A node's parameters, without the node.
class Parameters : public rclcpp::node_interfaces::NodeParametersInterface {
 public:
  const rclcpp::ParameterValue& declare_parameter(const std::string& name, const rclcpp::ParameterValue& default_value,
                                                  const rcl_interfaces::msg::ParameterDescriptor&, bool) override {
    const auto given = overrides.find(name);
    return declared_[name] = given == overrides.end() ? default_value : given->second;
  }
  bool has_parameter(const std::string& name) const override { return declared_.count(name) > 0; }
  bool get_parameter(const std::string& name, rclcpp::Parameter& parameter) const override {
    if (!has_parameter(name)) return false;
    parameter = {name, declared_.at(name)};
    return true;
  }
  rclcpp::node_interfaces::OnSetParametersCallbackHandle::SharedPtr add_on_set_parameters_callback(
      OnSetParametersCallbackType callback) override {
    auto handle = std::make_shared<rclcpp::node_interfaces::OnSetParametersCallbackHandle>();
    handle->callback = callback;
    on_set_ = handle;
    return handle;
  }
  rclcpp::node_interfaces::PostSetParametersCallbackHandle::SharedPtr add_post_set_parameters_callback(
      PostSetParametersCallbackType callback) override {
    auto handle = std::make_shared<rclcpp::node_interfaces::PostSetParametersCallbackHandle>();
    handle->callback = callback;
    post_set_ = handle;
    return handle;
  }
  // Why it was refused, or nothing.
  std::string set(const std::string& name, const rclcpp::ParameterValue& value) {
    const std::vector<rclcpp::Parameter> all = {{name, value}};
    if (const auto handle = on_set_.lock()) {
      const rcl_interfaces::msg::SetParametersResult result = handle->callback(all);
      if (!result.successful) return result.reason;
    }
    declared_[name] = value;
    if (const auto handle = post_set_.lock()) handle->callback(all);
    return "";
  }
  std::map<std::string, rclcpp::ParameterValue> overrides;

 private:
  std::map<std::string, rclcpp::ParameterValue> declared_;
  std::weak_ptr<rclcpp::node_interfaces::OnSetParametersCallbackHandle> on_set_;
  std::weak_ptr<rclcpp::node_interfaces::PostSetParametersCallbackHandle> post_set_;
};

Strings fields(const std::string& line, char separator) {
  Strings all;
  std::stringstream stream(line);
  for (std::string one; std::getline(stream, one, separator);) all.push_back(one);
  return all;
}

Eigen::VectorXd vector(const std::string& text) {
  std::vector<double> numbers;
  for (const std::string& one : fields(text, ' ')) numbers.push_back(std::stod(one));
  return Eigen::Map<Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

// The value of a parameter: of one type, named before it.
rclcpp::ParameterValue value_of(const std::string& type, const std::string& text) {
  if (type == "bool") return rclcpp::ParameterValue(text == "true");
  if (type == "double") return rclcpp::ParameterValue(std::stod(text));
  if (type == "strings") return rclcpp::ParameterValue(fields(text, ','));
  return rclcpp::ParameterValue(text);
}

template <class Call, class Out>
void report(Call call, const Out& out) {
  const long before = heap_calls;
  const bool done = call();
  std::printf("%d %ld", done, heap_calls - before);
  for (Eigen::Index c = 0; c < out.cols(); ++c)
    for (Eigen::Index r = 0; r < out.rows(); ++r) std::printf(" %.17g", out(r, c));
  std::printf("\n");
}

}  // namespace

int main() {
  pluginlib::ClassLoader<kinematics_interface::KinematicsInterface> loader("kinematics_interface",
                                                                           "kinematics_interface::KinematicsInterface");
  auto parameters = std::make_shared<Parameters>();
  std::shared_ptr<kinematics_interface::KinematicsInterface> plugin;
  for (std::string line; std::getline(std::cin, line); std::fflush(stdout)) {
    Strings f = fields(line, '\t');
    f.resize(6);
    const std::string &what = f[0], &link = f[1];
    if (what == "load") {
      plugin.reset(loader.createUnmanagedInstance(f[1]));
      parameters = std::make_shared<Parameters>();
      std::printf("1 0\n");
    } else if (what == "override") {
      parameters->overrides[f[1]] = value_of(f[2], f[3]);
      std::printf("1 0\n");
    } else if (what == "set") {
      std::printf("%s\n", parameters->set(f[1], value_of(f[2], f[3])).c_str());
    } else if (what == "initialize") {
      std::ifstream file(f[1]);
      std::stringstream text;
      text << file.rdbuf();
      std::printf("%d 0\n", plugin->initialize(f[1].empty() ? "" : text.str(), parameters, f[2]));
    } else if (what == "differ") {
      Eigen::Matrix<double, 7, 1> a = vector(f[1]), b = vector(f[2]);
      Eigen::Matrix<double, 6, 1> out;
      out.setZero();
      report([&] { return plugin->calculate_frame_difference(a, b, std::stod(f[3]), out); }, out);
    } else {
      const Eigen::VectorXd q = vector(f[2]);
      const Eigen::Index rows = f[4].empty() ? q.size() : std::stol(f[4]);
      if (what == "to_joints") {
        const Eigen::Matrix<double, 6, 1> delta = vector(f[3]);
        Eigen::VectorXd out = Eigen::VectorXd::Constant(rows, 77.0);
        report([&] { return plugin->convert_cartesian_deltas_to_joint_deltas(q, delta, link, out); }, out);
      } else if (what == "to_tool") {
        const Eigen::VectorXd delta = vector(f[3]);
        Eigen::Matrix<double, 6, 1> out;
        out.setConstant(77.0);
        report([&] { return plugin->convert_joint_deltas_to_cartesian_deltas(q, delta, link, out); }, out);
      } else if (what == "transform") {
        Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
        report([&] { return plugin->calculate_link_transform(q, link, out); }, out.matrix());
      } else if (what == "jacobian") {
        Eigen::Matrix<double, 6, Eigen::Dynamic> out = Eigen::MatrixXd::Constant(6, rows, 77.0);
        report([&] { return plugin->calculate_jacobian(q, link, out); }, out);
      } else if (what == "inverse") {
        Eigen::Matrix<double, Eigen::Dynamic, 6> out = Eigen::MatrixXd::Constant(rows, 6, 77.0);
        report([&] { return plugin->calculate_jacobian_inverse(q, link, out); }, out);
      } else {
        return 2;
      }
    }
  }
}
