#include "engine_client/cli/html/table.h"

namespace sweepstake::cli::html {
namespace {

Attributes CellAttributes(const TableCell& cell) {
  Attributes attributes;
  if (!cell.css_class.empty()) attributes.emplace_back("class", cell.css_class);
  if (cell.span > 1) attributes.emplace_back("colspan", std::to_string(cell.span));
  return attributes;
}

Markup HeaderCell(const TableCell& cell, const std::string& scope) {
  Attributes attributes = CellAttributes(cell);
  attributes.emplace_back("scope", scope);
  return Element("th", attributes, cell.content);
}

Markup HeadRow(const std::vector<TableCell>& cells) {
  Markup row;
  for (const TableCell& cell : cells) {
    // An empty corner heads nothing.
    row += cell.content.empty() ? Element("td", CellAttributes(cell), Markup())
                                : HeaderCell(cell, cell.span > 1 ? "colgroup" : "col");
  }
  return Element("tr", {}, row);
}

Markup BodyRow(const std::vector<TableCell>& cells) {
  Markup row;
  for (size_t i = 0; i < cells.size(); ++i) {
    row += i == 0 ? HeaderCell(cells[i], "row")
                  : Element("td", CellAttributes(cells[i]), cells[i].content);
  }
  return Element("tr", {}, row);
}

size_t ColumnCount(const Table& table) {
  size_t count = 0;
  for (const TableCell& cell : table.head.back()) count += cell.span;
  return count;
}

Markup Body(const TableGroup& group, const Table& table) {
  Markup rows;
  if (!group.title.empty()) {
    rows = Element("tr", {},
                   Element("th",
                           {{"class", "group"},
                            {"scope", "rowgroup"},
                            {"colspan", std::to_string(ColumnCount(table))}},
                           Element("span", {}, group.title)));
  }
  for (const auto& row : group.rows) rows += BodyRow(row);
  return Element("tbody", {}, rows);
}

}  // namespace

Markup DrawTable(const Table& table) {
  Markup head;
  for (const auto& row : table.head) head += HeadRow(row);
  Markup content =
      Element("caption", {}, Element("span", {}, table.caption)) + Element("thead", {}, head);
  for (const TableGroup& group : table.groups) content += Body(group, table);
  return Element(
      "div",
      {{"class", "scroll"}, {"tabindex", "0"}, {"role", "region"}, {"aria-label", table.caption}},
      Element("table", {{"id", table.id}}, content));
}

}  // namespace sweepstake::cli::html
