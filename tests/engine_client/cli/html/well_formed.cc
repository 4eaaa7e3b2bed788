#include "tests/engine_client/cli/html/well_formed.h"

#include <regex>
#include <set>
#include <vector>

namespace sweepstake::test_support {
namespace {

bool HasRawContent(const std::string& name) { return name == "script" || name == "style"; }

class Reader {
 public:
  explicit Reader(std::string_view html) : rest_(html) {}

  std::string Read() {
    while (!rest_.empty() && flaw_.empty()) {
      if (rest_.front() == '<') {
        ReadTag();
      } else {
        ReadText();
      }
    }
    if (flaw_.empty() && !open_.empty()) Say("<" + open_.back() + "> is never closed");
    return flaw_;
  }

 private:
  void ReadText() {
    const std::string text(rest_.substr(0, rest_.find('<')));
    static const std::regex kLoose("&(?!(amp|lt|gt|quot|#39);)|>");
    if (std::regex_search(text, kLoose)) Say("not escaped");
    rest_.remove_prefix(text.size());
  }

  void ReadTag() {
    static const std::regex kTag(
        R"(<(?:!DOCTYPE html|(/?)([a-z0-9]+)((?: [a-zA-Z0-9-]+="[^"<]*")*)(/?))>)",
        std::regex::optimize);
    std::match_results<std::string_view::const_iterator> match;
    if (!std::regex_search(rest_.begin(), rest_.end(), match, kTag,
                           std::regex_constants::match_continuous)) {
      return Say("no tag");
    }
    const std::string name = match[2].str();
    if (match[1].length() > 0) {
      if (open_.empty() || open_.back() != name) return Say("</" + name + "> closes nothing");
      open_.pop_back();
    } else if (!name.empty() && match[4].length() == 0) {
      open_.push_back(name);
    }
    ReadId(match[3].str());
    rest_.remove_prefix(static_cast<size_t>(match.length()));
    if (HasRawContent(name) && match[1].length() == 0) {
      rest_.remove_prefix(std::min(rest_.find("</"), rest_.size()));
    }
  }

  void ReadId(const std::string& attributes) {
    static const std::regex kId(R"re( id="([^"]*)")re");
    std::smatch match;
    if (!std::regex_search(attributes, match, kId)) return;
    if (!ids_.insert(match[1].str()).second) Say("id '" + match[1].str() + "' occurs twice");
  }

  void Say(const std::string& what) {
    if (flaw_.empty()) flaw_ = what + " at: " + std::string(rest_.substr(0, 120));
  }

  std::string_view rest_;
  std::vector<std::string> open_;
  std::set<std::string> ids_;
  std::string flaw_;
};

}  // namespace

std::string FirstFlaw(std::string_view html) { return Reader(html).Read(); }

}  // namespace sweepstake::test_support
