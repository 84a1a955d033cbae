// What the plugin uses of rclcpp's parameters, with the signatures of rclcpp.
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace rcl_interfaces::msg {
struct SetParametersResult {
  bool successful = false;
  std::string reason;
};
struct ParameterDescriptor {};
}  // namespace rcl_interfaces::msg

namespace rclcpp {

class ParameterValue {
 public:
  using Value = std::variant<std::monostate, bool, double, std::string, std::vector<std::string>>;
  ParameterValue() = default;
  template <class T>
  explicit ParameterValue(const T& value) : value_(value) {}
  template <class T>
  T get() const {
    if (const T* value = std::get_if<T>(&value_)) return *value;
    throw std::runtime_error("a parameter of another type");
  }

 private:
  Value value_;
};

class Parameter {
 public:
  Parameter() = default;
  Parameter(const std::string& name, const ParameterValue& value) : name_(name), value_(value) {}
  const std::string& get_name() const { return name_; }
  bool as_bool() const { return value_.get<bool>(); }
  double as_double() const { return value_.get<double>(); }
  std::string as_string() const { return value_.get<std::string>(); }
  std::vector<std::string> as_string_array() const { return value_.get<std::vector<std::string>>(); }

 private:
  std::string name_;
  ParameterValue value_;
};

namespace node_interfaces {

struct OnSetParametersCallbackHandle {
  using SharedPtr = std::shared_ptr<OnSetParametersCallbackHandle>;
  using OnSetParametersCallbackType =
      std::function<rcl_interfaces::msg::SetParametersResult(const std::vector<rclcpp::Parameter>&)>;
  OnSetParametersCallbackType callback;
};

struct PostSetParametersCallbackHandle {
  using SharedPtr = std::shared_ptr<PostSetParametersCallbackHandle>;
  using PostSetParametersCallbackType = std::function<void(const std::vector<rclcpp::Parameter>&)>;
  PostSetParametersCallbackType callback;
};

class NodeParametersInterface {
 public:
  using OnSetParametersCallbackType = OnSetParametersCallbackHandle::OnSetParametersCallbackType;
  using PostSetParametersCallbackType = PostSetParametersCallbackHandle::PostSetParametersCallbackType;
  virtual ~NodeParametersInterface() = default;
  virtual const rclcpp::ParameterValue& declare_parameter(
      const std::string& name, const rclcpp::ParameterValue& default_value,
      const rcl_interfaces::msg::ParameterDescriptor& parameter_descriptor = rcl_interfaces::msg::ParameterDescriptor(),
      bool ignore_override = false) = 0;
  virtual bool has_parameter(const std::string& name) const = 0;
  virtual bool get_parameter(const std::string& name, rclcpp::Parameter& parameter) const = 0;
  virtual OnSetParametersCallbackHandle::SharedPtr add_on_set_parameters_callback(
      OnSetParametersCallbackType callback) = 0;
  virtual PostSetParametersCallbackHandle::SharedPtr add_post_set_parameters_callback(
      PostSetParametersCallbackType callback) = 0;
};

}  // namespace node_interfaces
}  // namespace rclcpp
