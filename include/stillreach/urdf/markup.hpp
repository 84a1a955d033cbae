// What XML demands and tinyxml2 does not: characters, tags, attributes and references as the standard has them. A text
// that passes has no document type declaration, so that no entity expands without end or reads another file.
#pragma once

#include "stillreach/urdf/text.hpp"

STILLREACH_BEGIN
namespace urdf {

constexpr int kMaxDepth = 100, kMaxElements = 50000;
constexpr int kShownDepth = 90;  // deeper elements are blanked: tinyxml2 refuses a nesting of 100, or of 500

// Looks at a text once, from begin to end; comments, instructions and CDATA become spaces, lines stay.
class Markup {
 public:
  explicit Markup(std::string text) : text_(std::move(text)) {
    cut_the_end();
    one_kind_of_line();
    check_characters();
    blank_comments();
    if (text_.compare(0, 3, "\xEF\xBB\xBF") == 0) blank(0, 3);
    declaration();
    while (at_ < text_.size()) text_[at_] == '<' ? markup() : words();
    if (!open_.empty() || !rooted_) refuse(rooted_ ? "an element that is not closed" : "no element");
  }
  const std::string& text() const { return text_; }

  // The value of an attribute with its references resolved.
  static std::string resolved(const std::string& raw) {
    std::string value;
    for (std::size_t at = 0; at < raw.size();) {
      if (raw[at] == '&') {
        value += referred(raw, at);
      } else {
        value += raw[at] == '\n' || raw[at] == '\t' ? ' ' : raw[at];
        ++at;
      }
    }
    return value;
  }

 private:
  [[noreturn]] void refuse(const std::string& got, const std::string& expected = "well-formed XML") const {
    int line = 1;
    for (std::size_t i = 0; i < at_ && i < text_.size(); ++i) line += text_[i] == '\n';
    throw UrdfError(got, expected, line);
  }
  bool starts(const char* word) const { return text_.compare(at_, std::strlen(word), word) == 0; }
  char here() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  bool blank_here() const { return here() == ' ' || here() == '\t' || here() == '\n'; }
  bool skip() {
    const std::size_t before = at_;
    while (blank_here()) ++at_;
    return at_ > before;
  }
  void blank(std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i)
      if (text_[i] != '\n') text_[i] = ' ';
  }

  // The zeros that end a C string do not count.
  void cut_the_end() {
    const std::size_t last = text_.find_last_not_of(std::string(" \t\n\r\f\v\0", 7));
    if (last != std::string::npos && text_[last] == '>' && text_.find('\0', last) != std::string::npos)
      text_.resize(last + 1);
  }

  void one_kind_of_line() {
    std::size_t to = 0;
    for (std::size_t from = 0; from < text_.size(); ++from) {
      const bool carriage = text_[from] == '\r';
      if (carriage && from + 1 < text_.size() && text_[from + 1] == '\n') continue;
      text_[to++] = carriage ? '\n' : text_[from];
    }
    text_.resize(to);
  }

  static bool allowed(unsigned long c) {
    return c == 9 || c == 10 || c == 13 || (c >= 0x20 && c < 0xD800) || (c >= 0xE000 && c < 0xFFFE) ||
           (c >= 0x10000 && c < 0x110000);
  }

  void check_characters() {
    static const unsigned long least[] = {0, 0, 0x80, 0x800, 0x10000};
    for (at_ = 0; at_ < text_.size();) {
      const unsigned char first = static_cast<unsigned char>(text_[at_]);
      const std::size_t bytes = width(text_, at_);
      unsigned long c = bytes == 1 ? first : first & (0x7Fu >> bytes);
      bool right = !(first >= 0x80 && first < 0xC0) && first < 0xF8 && at_ + bytes <= text_.size();
      for (std::size_t i = 1; right && i < bytes; ++i) {
        const unsigned char next = static_cast<unsigned char>(text_[at_ + i]);
        right = (next & 0xC0) == 0x80;
        c = c << 6 | (next & 0x3Fu);
      }
      if (!right || c < least[bytes] || !allowed(c)) refuse("a character that XML does not have");
      at_ += bytes;
    }
    at_ = 0;
  }

  // Also those with -- in them, which XML forbids and most readers accept.
  void blank_comments() {
    for (std::size_t at = 0; (at = text_.find("<!", at)) != std::string::npos;) {
      const bool comment = text_.compare(at, 4, "<!--") == 0, data = text_.compare(at, 9, "<![CDATA[") == 0;
      if (!comment && !data) {
        ++at;
        continue;
      }
      const std::size_t inside = at + (comment ? 4 : 9), end = text_.find(comment ? "-->" : "]]>", inside);
      if (end == std::string::npos) return;
      if (comment) blank(at, end + 3);
      at = end + 3;
    }
  }

  // White space and further declarations before the last one are skipped, as most readers do.
  void declaration() {
    std::size_t last = std::string::npos;
    for (skip(); starts("<?xml") && text_.find_first_of(" \t\n", at_) == at_ + 5; skip()) {
      last = at_;
      at_ = text_.find('>', at_);
      if (at_ == std::string::npos) break;
      ++at_;
    }
    if (last == std::string::npos) return;
    at_ = last + 5;
    const char* const names[] = {"version", "encoding", "standalone"};
    std::size_t next = 0;
    while (skip() && here() != '?') {
      const std::string name = read_name(), value = read_value(false);
      while (next < 3 && name != names[next]) next = next == 0 ? 3 : next + 1;
      const bool word = value.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-_") ==
                        std::string::npos;
      const bool named = next != 1 || (!value.empty() && is_letter(value[0]));
      if (next >= 3 || !word || !named || (next == 2 && value != "yes" && value != "no"))
        refuse("an XML declaration that is none");
      ++next;
    }
    if (next == 0 || !starts("?>")) refuse("an XML declaration that is none");
    at_ += 2;
    blank(0, at_);
  }

  static bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
  static bool begins_name(char c) {
    return is_letter(c) || c == '_' || c == ':' || static_cast<unsigned char>(c) >= 0x80;
  }
  std::string read_name() {
    const std::size_t first = at_;
    if (!begins_name(here())) refuse("a name that begins with " + quoted(text_.substr(at_, width(text_ + '\0', at_))));
    while (begins_name(here()) || digit(here()) || here() == '-' || here() == '.') ++at_;
    return text_.substr(first, at_ - first);
  }
  // = and what stands in quotes behind it.
  std::string read_value(bool references) {
    skip();
    if (here() != '=') refuse("an attribute without a value");
    ++at_;
    skip();
    const char quote = here();
    const std::size_t first = at_ + 1, end = quote == '"' || quote == '\'' ? text_.find(quote, first) : text_.npos;
    if (end == std::string::npos) refuse("an attribute without quotes");
    for (++at_; at_ < end;) {
      if (here() == '<') refuse("< in an attribute");
      if (here() == '&' && references)
        check_reference();
      else
        ++at_;
    }
    ++at_;
    return text_.substr(first, end - first);
  }

  // What &...; stands for; `at` moves behind it. Empty where it stands for nothing.
  static std::string referred(const std::string& text, std::size_t& at) {
    static const struct {
      const char *name, *value;
    } known[] = {{"&amp;", "&"}, {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&apos;", "'"}};
    for (const auto& one : known)
      if (text.compare(at, std::strlen(one.name), one.name) == 0) {
        at += std::strlen(one.name);
        return one.value;
      }
    if (text.compare(at, 2, "&#") != 0) return {};
    const bool hex = text.compare(at + 2, 1, "x") == 0;
    std::size_t i = at + (hex ? 3 : 2);
    const std::size_t first = i;
    unsigned long c = 0;
    for (; i < text.size() && c < 0x110000; ++i) {
      const char d = text[i];
      if (digit(d))
        c = c * (hex ? 16 : 10) + static_cast<unsigned long>(d - '0');
      else if (hex && ((d >= 'a' && d <= 'f') || (d >= 'A' && d <= 'F')))
        c = c * 16 + static_cast<unsigned long>((d | 32) - 'a' + 10);
      else
        break;
    }
    if (i == first || i >= text.size() || text[i] != ';' || !allowed(c)) return {};
    at = i + 1;
    return encoded(c);
  }
  static std::string encoded(unsigned long c) {
    const auto rest = [c](int shift) { return static_cast<char>(0x80 | (c >> shift & 0x3F)); };
    if (c < 0x80) return {static_cast<char>(c)};
    if (c < 0x800) return {static_cast<char>(0xC0 | c >> 6), rest(0)};
    if (c < 0x10000) return {static_cast<char>(0xE0 | c >> 12), rest(6), rest(0)};
    return {static_cast<char>(0xF0 | c >> 18), rest(12), rest(6), rest(0)};
  }
  void check_reference() {
    if (referred(text_, at_).empty()) refuse("an undefined entity, or & alone");
  }

  void words() {
    for (; at_ < text_.size() && here() != '<';) {
      if (open_.empty() && !blank_here()) refuse("text outside the root element");
      if (starts("]]>")) refuse("]]> in a text");
      if (here() == '&')
        check_reference();
      else
        ++at_;
    }
  }

  void markup() {
    const std::size_t first = at_;
    if (starts("</")) return closing();
    if (starts("<?")) return instruction(first);
    if (starts("<![CDATA[") && !open_.empty()) {
      const std::size_t end = text_.find("]]>", at_);
      if (end == std::string::npos) refuse("CDATA that does not end");
      at_ = end + 3;
      return blank(first, at_);
    }
    if (starts("<!DOCTYPE"))
      refuse("a document type declaration (<!DOCTYPE)",
             "a file without one: entities could expand without end or read other files");
    if (starts("<!")) refuse("a comment that does not end, or another <!");
    opening();
  }

  void instruction(std::size_t first) {
    at_ += 2;
    std::string target = read_name();
    for (char& c : target) c = is_letter(c) ? static_cast<char>(c | 32) : c;
    const std::size_t end = text_.find("?>", at_);
    if (target == "xml" || end == std::string::npos || (end > at_ && !blank_here()))
      refuse("a declaration that is not at the beginning, or an instruction that does not end");
    at_ = end + 2;
    blank(first, at_);
  }

  void closing() {
    const std::size_t first = at_;
    at_ += 2;
    const std::string name = read_name();
    skip();
    if (here() != '>' || open_.empty() || open_.back() != name) refuse("mismatched tag " + quoted(name));
    ++at_;
    if (open_.size() > kShownDepth) blank(first, at_);
    open_.pop_back();
  }

  void opening() {
    const std::size_t first = at_;
    if (open_.empty() && rooted_) refuse("a second root element");
    rooted_ = true;
    ++at_;
    open_.push_back(read_name());
    std::vector<std::string> names;
    while (skip() && here() != '>' && here() != '/') {
      const std::string name = read_name();
      for (const std::string& other : names)
        if (other == name) refuse("an attribute twice: " + quoted(name));
      names.push_back(name);
      read_value(true);
    }
    const bool alone = here() == '/';
    if (alone) ++at_;
    if (here() != '>') refuse("a tag that does not end");
    const int depth = static_cast<int>(open_.size());
    if (depth > kMaxDepth)
      refuse("elements nested " + std::to_string(depth) + " deep", "at most " + std::to_string(kMaxDepth));
    if (++count_ > kMaxElements)
      refuse("more than " + std::to_string(kMaxElements) + " elements", "at most " + std::to_string(kMaxElements));
    ++at_;
    if (depth > kShownDepth) blank(first, at_);
    if (alone) open_.pop_back();
  }

  std::string text_;
  std::size_t at_ = 0;
  std::vector<std::string> open_;
  int count_ = 0;
  bool rooted_ = false;
};

}  // namespace urdf
STILLREACH_END
