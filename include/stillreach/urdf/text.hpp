// Texts of robot files, in UTF-8: white space, words, numbers, and how messages quote them.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstring>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "stillreach/types.hpp"

STILLREACH_BEGIN

// Why a URDF text is refused: what came, what was expected, and where: its line and element, or the argument.
class UrdfError : public std::invalid_argument {
 public:
  UrdfError(std::string got_, std::string expected_, int line_ = 0, std::string element_ = {},
            std::string argument_ = {})
      : std::invalid_argument(message(got_, expected_, line_, element_, argument_)),
        got(std::move(got_)),
        expected(std::move(expected_)),
        element(std::move(element_)),
        argument(std::move(argument_)),
        line(line_) {}
  std::string got, expected, element, argument;  // the last two may be empty
  int line;                                      // 0 where it is no single line

 private:
  static std::string message(const std::string& got, const std::string& expected, int line, const std::string& element,
                             const std::string& argument) {
    std::string place = "URDF";
    if (line > 0) place += ", line " + std::to_string(line);
    if (!element.empty()) place += ", " + element;
    if (!argument.empty()) place += ", " + argument;
    return place + ": got " + got + ", expected " + expected;
  }
};

namespace urdf {

// Bytes of the character at `at` of valid UTF-8.
inline std::size_t width(const std::string& text, std::size_t at) {
  const unsigned char c = static_cast<unsigned char>(text[at]);
  return c < 0x80 ? 1 : c < 0xE0 ? 2 : c < 0xF0 ? 3 : 4;
}

inline std::size_t characters(const std::string& text) {
  std::size_t count = 0;
  for (char c : text) count += (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  return count;
}

// Bytes of the white space at `at`, 0 where there is none; Unicode's spaces count, as in Python.
inline std::size_t space(const std::string& text, std::size_t at) {
  static const char* const wide[] = {"\xC2\x85",     "\xC2\xA0",     "\xE1\x9A\x80", "\xE2\x80\x80", "\xE2\x80\x81",
                                     "\xE2\x80\x82", "\xE2\x80\x83", "\xE2\x80\x84", "\xE2\x80\x85", "\xE2\x80\x86",
                                     "\xE2\x80\x87", "\xE2\x80\x88", "\xE2\x80\x89", "\xE2\x80\x8A", "\xE2\x80\xA8",
                                     "\xE2\x80\xA9", "\xE2\x80\xAF", "\xE2\x81\x9F", "\xE3\x80\x80"};
  if (text[at] == ' ' || text[at] == '\t' || text[at] == '\n' || text[at] == '\r') return 1;
  if (static_cast<unsigned char>(text[at]) < 0x80) return 0;
  for (const char* one : wide)
    if (text.compare(at, std::strlen(one), one) == 0) return std::strlen(one);
  return 0;
}

inline std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> words;
  bool inside = false;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t blank = space(text, at), step = blank ? blank : width(text, at);
    if (blank == 0) {
      if (!inside) words.emplace_back();
      words.back().append(text, at, step);
    }
    inside = blank == 0;
    at += step;
  }
  return words;
}

// Without white space around it.
inline std::string strip(const std::string& text) {
  std::size_t first = std::string::npos, last = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t blank = space(text, at), step = blank ? blank : width(text, at);
    if (blank == 0) {
      if (first == std::string::npos) first = at;
      last = at + step;
    }
    at += step;
  }
  return first == std::string::npos ? std::string() : text.substr(first, last - first);
}

inline bool digit(char c) { return c >= '0' && c <= '9'; }

// A decimal number, such as -1.5e-3; NaN for anything else, and for what no double holds. No locale changes it.
inline double number(const std::string& word) {
  std::size_t at = word[0] == '+' || word[0] == '-' ? 1 : 0, digits = 0;
  for (; at < word.size() && digit(word[at]); ++at) ++digits;
  if (at < word.size() && word[at] == '.')
    for (++at; at < word.size() && digit(word[at]); ++at) ++digits;
  if (digits == 0) return std::nan("");
  if (at < word.size() && (word[at] == 'e' || word[at] == 'E')) {
    if (++at < word.size() && (word[at] == '+' || word[at] == '-')) ++at;
    if (at == word.size()) return std::nan("");
    while (at < word.size() && digit(word[at])) ++at;
  }
  if (at != word.size()) return std::nan("");
  std::istringstream stream(word);
  stream.imbue(std::locale::classic());
  double value = 0.0;
  stream >> value;
  return stream.fail() && std::abs(value) >= 1.0 ? std::nan("") : value;  // a number too small is 0, or nearly
}

inline std::string printed(double value, const char* format = "%g") {
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

// In quotes, as Python writes it; at most 60 characters.
inline std::string quoted(const std::string& text) {
  const bool apostrophe = text.find('\'') != std::string::npos, mark = text.find('"') != std::string::npos;
  const char quote = apostrophe && !mark ? '"' : '\'';
  std::string all(1, quote);
  for (char c : text) {
    if (c == '\\' || c == quote) all += '\\';
    if (c == '\t' || c == '\n' || c == '\r')
      all += c == '\t' ? "\\t" : c == '\n' ? "\\n" : "\\r";
    else
      all += c;
  }
  all += quote;
  std::size_t end = 0;
  for (int count = 0; end < all.size() && count < 60; ++count) end += width(all, end);
  return end < all.size() ? all.substr(0, end) + "…" : all;
}

// Names in a row; of many the first 30, and how many more.
template <class Names>
std::string listed(const Names& names) {
  std::string row;
  std::size_t count = 0;
  for (const std::string& name : names) {
    if (++count > 30) continue;
    row += (count > 1 ? ", " : "") + name;
  }
  if (count > 30) row += " and " + std::to_string(count - 30) + " more";
  return count == 0 ? "none exist" : row;
}

}  // namespace urdf

STILLREACH_END
