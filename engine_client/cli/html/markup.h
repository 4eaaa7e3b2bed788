// HTML and SVG text that is safe to put together: what comes in as a string is escaped, and only
// Trusted lets through what is markup already. So a name from a file cannot become an element.
// Value type; pure functions, safe from any thread.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sweepstake::cli::html {

class Markup {
 public:
  Markup() = default;
  // Text, escaped; bytes that are no UTF-8 and control characters become U+FFFD.
  Markup(std::string_view text);                                       // NOLINT: text converts
  Markup(const std::string& text) : Markup(std::string_view(text)) {}  // NOLINT
  Markup(const char* text) : Markup(std::string_view(text)) {}         // NOLINT

  // REQUIRES: `html` holds no text from outside.
  static Markup Trusted(std::string html);

  Markup& operator+=(const Markup& more);
  bool empty() const { return html_.empty(); }
  const std::string& html() const { return html_; }

 private:
  std::string html_;
};

Markup operator+(Markup first, const Markup& second);

// Names are ours, values are escaped.
using Attributes = std::vector<std::pair<std::string_view, std::string>>;

// <name attributes>content</name>
Markup Element(std::string_view name, const Attributes& attributes, const Markup& content);
// <name attributes/>, for elements that have no content.
Markup Element(std::string_view name, const Attributes& attributes);

// `text` with & < > " ' as character references.
std::string Escape(std::string_view text);

// A JSON document that may stand inside <script type="application/json">: no "<" remains in it.
Markup EmbeddedJson(std::string_view json);

}  // namespace sweepstake::cli::html
