// The links and joints of a URDF text as one tree.
#pragma once

#include <utility>

#include "stillreach/urdf/element.hpp"

STILLREACH_BEGIN
namespace urdf {

struct Version {
  int major = 1, minor = 0;
  bool operator>=(const Version& other) const {
    return major > other.major || (major == other.major && minor >= other.minor);
  }
};

class Tree {
 public:
  explicit Tree(const Element& robot) : robot_(robot) {
    if (robot.tag != "robot") throw UrdfError("<" + robot.tag + ">", "<robot>, the root of a URDF file", robot.line);
    version_ = read_version();
    named("link", [this](const std::string& name, const Element&) { links_.push_back(name); });
    if (links_.empty()) robot.refuse("a robot without links", "at least one <link>");
    std::vector<const Element*> ordered;
    named("joint", [&](const std::string& name, const Element& joint) {
      joints_[name] = &joint;
      names_.push_back(name);
      ordered.push_back(&joint);
    });
    known_.insert(links_.begin(), links_.end());
    for (const Element* joint : ordered) {
      const std::string parent = end_of(*joint, "parent"), child = end_of(*joint, "child");
      if (above_.count(child))
        joint->refuse("a second parent for link " + quoted(child) + ", which is already the child of " +
                          above_[child].first->label(),
                      "one parent for each link: a tree");
      above_[child] = {joint, parent};
    }
    find_root();
  }

  const std::vector<std::string>& links() const { return links_; }
  const std::vector<std::string>& joint_names() const { return names_; }
  bool has_link(const std::string& name) const { return known_.count(name) > 0; }
  const std::string& root() const { return root_; }
  Version version() const { return version_; }
  // A joint by its name, or null.
  const Element* joint(const std::string& name) const {
    const auto found = joints_.find(name);
    return found == joints_.end() ? nullptr : found->second;
  }
  // The joint above a link and its parent link, or null for the root.
  const std::pair<const Element*, std::string>* above(const std::string& link) const {
    const auto found = above_.find(link);
    return found == above_.end() ? nullptr : &found->second;
  }

  // The links without children below a base, or all of them where nothing is below it.
  std::vector<std::string> leaves(const std::string& base) const {
    std::set<std::string> parents;
    for (const auto& one : above_) parents.insert(one.second.second);
    const std::map<std::string, std::string> tops = find_tops(&base);
    std::vector<std::string> all, below;
    for (const std::string& link : links_)
      if (!parents.count(link) && link != base) {
        all.push_back(link);
        if (tops.at(link) == base) below.push_back(link);
      }
    return below.empty() ? all : below;
  }

 private:
  Version read_version() const {
    if (!robot_.has("version")) return {};
    const std::string& text = robot_.attributes.at("version");
    const std::string word = strip(text);
    std::size_t at = 0;
    const int major = read_digits(word, at);
    const bool point = at < word.size() && word[at] == '.';
    const int minor = point ? read_digits(word, ++at) : -1;
    if (major != 1 || minor < 0 || minor > 2 || at != word.size())
      robot_.refuse("version=" + quoted(text), "1.0, 1.1, 1.2");
    return {major, minor};
  }
  // A number of at most four digits behind zeros, or -1.
  static int read_digits(const std::string& word, std::size_t& at) {
    int value = 0;
    std::size_t count = 0;
    for (; at < word.size() && digit(word[at]); ++at, ++count)
      if (value < 100000) value = 10 * value + (word[at] - '0');
    return count == 0 || value > 9999 ? -1 : value;
  }

  template <class Add>
  void named(const char* tag, Add add) const {
    std::map<std::string, int> seen;
    for (const auto& one : robot_.children) {
      if (one->tag != tag) continue;
      const std::string name = one->word("name");
      if (name.empty()) one->refuse("no name", "a name");
      if (seen.count(name))
        one->refuse("a second " + one->label() + "; the first is in line " + std::to_string(seen[name]),
                    "unique names");
      seen[name] = one->line;
      add(name, *one);
    }
  }

  // The link at one end of a joint.
  std::string end_of(const Element& joint, const char* tag) const {
    std::vector<const Element*> ends;
    std::set<std::string> names;
    for (const auto& one : joint.children)
      if (one->tag == tag) {
        ends.push_back(one.get());
        names.insert(one->word("link"));
      }
    const int line = ends.empty() ? joint.line : ends[0]->line;
    const std::string link = ends.empty() ? "" : ends[0]->word("link");
    const std::string shown = std::string("<") + tag + ">";
    if (names.size() > 1)
      throw UrdfError(std::to_string(names.size()) + " " + shown + " that differ", "one", ends[1]->line, joint.label());
    if (link.empty())
      throw UrdfError(std::string("no ") + tag + " link", std::string("<") + tag + " link=\"...\"/>", line,
                      joint.label());
    if (!known_.count(link))
      throw UrdfError(quoted(link), std::string("a link of the file as ") + tag + ": " + listed(links_), line,
                      joint.label());
    return link;
  }

  void find_root() {
    std::vector<std::string> roots;
    for (const std::string& link : links_)
      if (!above_.count(link)) roots.push_back(quoted(link));
    if (roots.size() > 1) {
      std::string got = std::to_string(roots.size()) + " links without a parent: ";
      for (std::size_t i = 0; i < roots.size() && i < 5; ++i) got += (i ? ", " : "") + roots[i];
      throw UrdfError(got + (roots.size() > 5 ? ", ..." : ""), "one tree of connected links");
    }
    root_ = find_tops(nullptr).at(links_[0]);
  }

  // By link, the end of the way upwards: the base or the root; refuses a cycle.
  std::map<std::string, std::string> find_tops(const std::string* base) const {
    std::map<std::string, std::string> tops;
    for (const std::string& first : links_) {
      std::string link = first;
      std::set<std::string> walk;
      while (above_.count(link) && !(base && link == *base) && !tops.count(link)) {
        const auto& [joint, parent] = above_.at(link);
        if (!walk.insert(link).second)
          joint->refuse("a cycle: link " + quoted(link) + " is above its own parent " + quoted(parent),
                        "a tree, without cycles");
        link = parent;
      }
      const std::string top = tops.count(link) ? tops[link] : link;
      walk.insert(link);
      for (const std::string& one : walk) tops[one] = top;
    }
    return tops;
  }

  const Element& robot_;
  Version version_;
  std::vector<std::string> links_, names_;
  std::set<std::string> known_;
  std::map<std::string, const Element*> joints_;
  std::map<std::string, std::pair<const Element*, std::string>> above_;
  std::string root_;
};

}  // namespace urdf
STILLREACH_END
