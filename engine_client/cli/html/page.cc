#include "engine_client/cli/html/page.h"

#include "engine_client/cli/html/line_chart.h"
#include "engine_client/cli/html/page_assets.h"

namespace sweepstake::cli::html {
namespace {

constexpr const char* kPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; base-uri 'none'; "
    "form-action 'none'";

// A box of a legend hides its line: one rule per box there can be.
std::string ToggleRules() {
  std::string rules;
  for (size_t i = 0; i < kMostToggles; ++i) {
    const std::string key = ".k" + std::to_string(i);
    rules.append(".chart:has(label").append(key).append(">input:not(:checked)) .series");
    rules.append(key).append("{display:none}\n");
  }
  return rules;
}

Markup Head(const Page& page) {
  return Element(
      "head", {},
      Element("meta", {{"charset", "utf-8"}}) +
          Element("meta", {{"http-equiv", "Content-Security-Policy"}, {"content", kPolicy}}) +
          Element("meta",
                  {{"name", "viewport"}, {"content", "width=device-width, initial-scale=1"}}) +
          Element("title", {}, page.title) +
          Element("style", {}, Markup::Trusted(std::string(PageStyle()) + ToggleRules())));
}

Markup ThemeChoice(const std::string& value, const std::string& text, bool checked) {
  Attributes attributes{
      {"type", "radio"}, {"name", "theme"}, {"id", "theme-" + value}, {"value", value}};
  if (checked) attributes.emplace_back("checked", "checked");
  return Element("label", {}, Element("input", attributes) + Element("span", {}, text));
}

Markup ThemeSwitch() {
  return Element("fieldset", {{"class", "theme"}},
                 Element("legend", {}, "Theme") + ThemeChoice("auto", "Auto", true) +
                     ThemeChoice("light", "Light", false) + ThemeChoice("dark", "Dark", false));
}

Markup Contents(const std::vector<PageSection>& sections) {
  Markup links;
  for (const PageSection& section : sections) {
    links += Element("li", {}, Element("a", {{"href", "#" + section.id}}, section.heading));
  }
  return Element("nav", {{"aria-label", "Contents"}}, Element("ol", {}, links));
}

Markup Sections(const std::vector<PageSection>& sections) {
  Markup all;
  for (const PageSection& section : sections) {
    all +=
        Element("section", {{"id", section.id}, {"aria-labelledby", section.id + "-heading"}},
                Element("h2", {{"id", section.id + "-heading"}}, section.heading) + section.body);
  }
  return all;
}

}  // namespace

std::string WritePage(const Page& page) {
  const Markup header =
      Element("header", {},
              Element("div", {{"class", "title"}}, Element("h1", {}, page.title) + ThemeSwitch()) +
                  page.lead + Contents(page.sections));
  const Markup body =
      Element("body", {},
              header + Element("main", {}, Sections(page.sections)) +
                  Element("script", {}, Markup::Trusted(std::string(PageScript()))));
  return "<!DOCTYPE html>\n" + Element("html", {{"lang", "en"}}, Head(page) + body).html() + "\n";
}

Markup EmbedRows(const std::string& id, const std::string& json) {
  const Markup buttons =
      Element("button", {{"type", "button"}, {"data-copy", "json"}, {"data-source", id}},
              "Copy JSON") +
      Element("button", {{"type", "button"}, {"data-copy", "csv"}, {"data-source", id}},
              "Copy CSV") +
      Element("span", {{"class", "copied"}, {"role", "status"}}, Markup());
  return Element("p", {{"class", "copy"}, {"hidden", "hidden"}}, buttons) +
         Element("script", {{"type", "application/json"}, {"id", id}}, EmbeddedJson(json));
}

}  // namespace sweepstake::cli::html
