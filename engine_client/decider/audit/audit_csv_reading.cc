// The reading half of audit_csv.h: AuditCsvReader. The writing half is in audit_csv.cc.
#include <algorithm>
#include <optional>
#include <utility>

#include "engine_client/decider/audit/audit_csv.h"
#include "engine_client/decider/audit/field_text.h"

namespace sweepstake::decision {
namespace {

using Lines = std::vector<std::vector<std::string>>;

// The position of a cell within the lines of a row.
struct Place {
  size_t item = 0;
  size_t column = 0;
};

// Reads the fields of a row from its cells. An optional value is present if one of its cells has
// text. A list has as many items as there are lines with text in its columns.
class CellReader {
 public:
  explicit CellReader(const Lines& lines) : lines_(lines) {}

  template <typename T>
  void operator()(std::string_view name, T& value) {
    if constexpr (AuditStruct<T>) {
      VisitFields(value, *this);
    } else if constexpr (kIsOptional<T>) {
      value.reset();
      typename T::value_type known{};
      if (ReadsText(name, known)) value = std::move(known);
    } else if constexpr (kIsList<T>) {
      value.clear();
      const size_t column = column_;
      for (item_ = 0; item_ < lines_.size(); ++item_) {
        column_ = column;
        typename T::value_type item{};
        if (ReadsText(name, item)) value.push_back(std::move(item));
      }
      item_ = 0;
    } else {
      value = T{};
      const std::string& cell = lines_[item_][column_];
      found_text_ = found_text_ || !cell.empty();
      if (!ReadField(cell, value) && !wrong_) wrong_ = {item_, column_};
      ++column_;
    }
  }

  const std::optional<Place>& wrong() const { return wrong_; }

 private:
  template <typename T>
  bool ReadsText(std::string_view name, T& value) {
    const bool before = std::exchange(found_text_, false);
    (*this)(name, value);
    return std::exchange(found_text_, found_text_ || before);
  }

  const Lines& lines_;
  size_t column_ = 1;  // starts after the column `item`
  size_t item_ = 0;
  bool found_text_ = false;
  std::optional<Place> wrong_;
};

// Writes the row again and returns the first cell whose text differs from the file's.
std::optional<Place> OddPlace(const AuditRow& row, const Lines& lines) {
  Lines written = AuditCells(row);
  written.resize(lines.size(), std::vector<std::string>(AuditColumns().size()));
  for (size_t item = 0; item < lines.size(); ++item) {
    for (size_t column = 0; column < lines[item].size(); ++column) {
      if (lines[item][column] != written[item][column]) return Place{item, column};
    }
  }
  return std::nullopt;
}

}  // namespace

AuditCsvReader::AuditCsvReader(std::string_view csv) : lines_(csv) {
  if (lines_.Next(ahead_) && ahead_ == AuditColumns()) {
    ReadAhead();
    return;
  }
  problem_ = ahead_.empty()             ? "the file is empty"
             : lines_.problem().empty() ? "this is not the header of an audit log of this version"
                                        : lines_.problem();
  ahead_.clear();
}

bool AuditCsvReader::ReadAhead() {
  const bool is_read = lines_.Next(ahead_);
  if (is_read && ahead_.size() == AuditColumns().size()) return true;
  if (is_read) {
    problem_ = "has " + std::to_string(ahead_.size()) + " cells instead of " +
               std::to_string(AuditColumns().size()) + "; is it cut off?";
  } else {
    problem_ = lines_.problem();
  }
  ahead_.clear();
  return false;
}

bool AuditCsvReader::Next(AuditRow& row) {
  line_ = lines_.line();
  if (ahead_.empty()) return false;
  Lines lines{ahead_};
  while (ReadAhead() && ahead_[0] == std::to_string(lines.size()) &&
         std::equal(ahead_.begin() + 1, ahead_.begin() + 4, lines[0].begin() + 1))
    lines.push_back(ahead_);
  if (!problem_.empty()) {  // the wrong line may belong to this row
    line_ = lines_.line();
    return false;
  }
  CellReader reader(lines);
  VisitFields(row, reader);
  const auto wrong = reader.wrong() ? reader.wrong() : OddPlace(row, lines);
  if (!wrong) return true;
  column_ = AuditColumns()[wrong->column];
  problem_ = "is not readable: " + lines[wrong->item][wrong->column].substr(0, 80);
  return false;
}

}  // namespace sweepstake::decision
