// The kinematic part of a URDF text: elements down to robot/joint/*, with lines; they make their own errors.
#pragma once

#include <tinyxml2.h>

#include <map>
#include <memory>
#include <set>

#include "stillreach/urdf/markup.hpp"

STILLREACH_BEGIN
namespace urdf {

constexpr std::size_t kMaxBytes = std::size_t{16} << 20;
constexpr int kKeptDepth = 3;
constexpr std::size_t kMaxAttribute = 1000;
constexpr double kAnyNumber = HUGE_VAL;
inline const char* xacro_advice() {
  return "a plain URDF file: expand xacro first, e.g. `xacro robot.urdf.xacro > robot.urdf`";
}

// Its tag (of xacro: with the prefix xacro:, whatever the file's), attributes, line and children.
struct Element {
  std::string tag;
  std::map<std::string, std::string> attributes;
  int line = 0;
  const Element* within = nullptr;
  bool missing = false;
  std::vector<std::unique_ptr<Element>> children = {};

  // Its name in messages: <robot>, joint 'elbow', joint 'elbow' <origin>.
  std::string label() const {
    const std::string own = "<" + tag.substr(0, 80) + ">";
    if (!within) return own;
    if (within->within) return within->label() + " " + own;
    return word("name").empty() ? own : tag + " " + quoted(word("name"));
  }
  [[noreturn]] void refuse(const std::string& got, const std::string& expected) const {
    throw UrdfError(got, expected, line, label());
  }
  bool has(const char* name) const { return attributes.count(name) > 0; }
  // The first child with that tag, as in other readers; or a missing one without attributes.
  const Element& child(const char* name) const {
    for (const auto& one : children)
      if (one->tag == name) return *one;
    auto& none = absent[name];
    if (!none) none.reset(new Element{name, {}, line, this, true});
    return *none;
  }
  // An attribute without the white space around it.
  std::string word(const char* name) const {
    const auto found = attributes.find(name);
    return found == attributes.end() ? std::string() : strip(found->second);
  }
  // The number in an attribute; `otherwise` where it is missing.
  double number(const char* name, double otherwise, double largest = kAnyNumber) const {
    if (!has(name)) return otherwise;
    return one_number(name, plain(name), largest);
  }
  // The `count` numbers in an attribute.
  std::vector<double> numbers(const char* name, std::size_t count, double largest = kAnyNumber) const {
    if (!has(name)) refuse(std::string("no ") + name, expected_numbers(name, count));
    const std::string& text = plain(name);
    const std::vector<std::string> words = split(text);
    if (words.size() != count)
      refuse(std::to_string(words.size()) + " numbers in " + name + "=" + quoted(text), expected_numbers(name, count));
    std::vector<double> all;
    for (const std::string& one : words) all.push_back(one_number(name, one, largest));
    return all;
  }

  mutable std::map<std::string, std::unique_ptr<Element>> absent = {};

 private:
  static std::string expected_numbers(const char* name, std::size_t count) {
    std::string zeros;
    for (std::size_t i = 1; i < count; ++i) zeros += "0 ";
    return std::to_string(count) + " numbers, e.g. " + name + "='" + zeros + "1'";
  }
  const std::string& plain(const char* name) const {
    const std::string& text = attributes.at(name);
    if (text.find('$') != std::string::npos)
      refuse(std::string("xacro in ") + name + "=" + quoted(text), xacro_advice());
    return text;
  }
  double one_number(const char* name, const std::string& text, double largest) const {
    const double value = urdf::number(strip(text));
    if (!std::isfinite(value)) refuse(name + ("=" + quoted(text)), "a finite number, e.g. '0.5'");
    if (std::abs(value) > largest)
      refuse(name + ("=" + quoted(text)), "a number between -" + printed(largest) + " and " + printed(largest));
    return value;
  }
};

// Makes elements of what tinyxml2 read.
class Elements {
 public:
  static std::unique_ptr<Element> of(const std::string& text) {
    if (text.size() > kMaxBytes) throw UrdfError("more than 16 MiB", "a file of at most 16 MiB");
    const Markup markup(text);
    tinyxml2::XMLDocument document(false);  // attributes come as they are written
    if (document.Parse(markup.text().c_str(), markup.text().size()) != tinyxml2::XML_SUCCESS)
      throw UrdfError(document.ErrorName(), "well-formed XML", document.ErrorLineNum());
    Elements all;
    return all.read(*document.RootElement(), nullptr, 1);
  }

 private:
  std::unique_ptr<Element> read(const tinyxml2::XMLElement& from, const Element* within, int depth) {
    const int line = from.GetLineNum();
    auto element = std::make_unique<Element>();
    element->tag = from.Name();
    element->line = line;
    element->within = within;
    for (const tinyxml2::XMLAttribute* a = from.FirstAttribute(); a; a = a->Next())
      element->attributes[a->Name()] = Markup::resolved(a->Value());
    expand(*element);
    if (depth <= kKeptDepth)
      for (const auto& [name, value] : element->attributes)
        if (characters(value) > kMaxAttribute)
          throw UrdfError(std::to_string(characters(value)) + " characters in " + quoted(name),
                          "at most " + std::to_string(kMaxAttribute), line, "<" + element->tag.substr(0, 80) + ">");
    for (const tinyxml2::XMLElement* c = from.FirstChildElement(); c; c = c->NextSiblingElement()) {
      std::unique_ptr<Element> child = read(*c, element.get(), depth + 1);
      if (depth < kKeptDepth) element->children.push_back(std::move(child));
    }
    return element;
  }

  // Refuses elements of xacro that can add links or joints; a call of a macro, which nobody expanded, cannot.
  void expand(Element& element) {
    for (const auto& [name, value] : element.attributes) {
      const std::size_t end = value.find_last_not_of('/') + 1;
      if (name.compare(0, 6, "xmlns:") == 0 && end >= 5 && value.compare(end - 5, 5, "xacro") == 0)
        prefixes_.insert(name.substr(6));
    }
    static const std::set<std::string> adding = {"include", "macro",  "call",    "insert_block",
                                                 "if",      "unless", "element", "attribute"};
    const std::size_t colon = element.tag.find(':');
    if (colon == std::string::npos || colon + 1 == element.tag.size() || !prefixes_.count(element.tag.substr(0, colon)))
      return;
    const std::string word = element.tag.substr(colon + 1), shown = "<" + element.tag.substr(0, 80) + ">";
    if (adding.count(word)) throw UrdfError("xacro (" + shown + ")", xacro_advice(), element.line, shown);
    element.tag = "xacro:" + word;
  }

  std::set<std::string> prefixes_ = {"xacro"};
};

}  // namespace urdf
STILLREACH_END
