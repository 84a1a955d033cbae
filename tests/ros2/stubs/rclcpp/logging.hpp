// What the plugin uses of rclcpp's logging: messages go to standard error.
#pragma once

#include <cstdio>
#include <string>

namespace rclcpp {
struct Logger {
  std::string name;
};
inline Logger get_logger(const std::string& name) { return {name}; }
}  // namespace rclcpp

#define RCLCPP_ERROR(logger, ...) \
  (std::fprintf(stderr, "%s: ", (logger).name.c_str()), std::fprintf(stderr, __VA_ARGS__), std::fputc('\n', stderr))
#define RCLCPP_WARN RCLCPP_ERROR
