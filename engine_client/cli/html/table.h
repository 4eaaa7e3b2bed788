// A table with a caption, grouped header cells and grouped rows, in a box of its own that scrolls
// where the page is narrower. Pure function, safe from any thread.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli::html {

struct TableCell {
  TableCell() = default;
  TableCell(Markup cell_content, std::string cell_class = {},
            size_t cell_span = 1)  // NOLINT: converts
      : content(std::move(cell_content)), css_class(std::move(cell_class)), span(cell_span) {}

  Markup content;
  std::string css_class;  // may be empty
  size_t span = 1;        // columns
};

struct TableGroup {
  Markup title;  // a row of its own above the rows; none when empty
  std::vector<std::vector<TableCell>> rows;
};

struct Table {
  std::string id;       // one on the page
  std::string caption;  // what it shows, in words
  std::vector<std::vector<TableCell>> head;
  // The first cell of a row names it; the others hold numbers unless their class has "text" in it.
  std::vector<TableGroup> groups;
};

Markup DrawTable(const Table& table);

}  // namespace sweepstake::cli::html
