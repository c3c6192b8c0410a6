// Names that a mistyped one may have meant.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

namespace regulus {

/// Least number of letters to insert, remove, replace or swap with their neighbour that makes `a` of `b`,
/// no letter touched twice (optimal string alignment); upper and lower case are the same.
inline size_t edit_distance(std::string_view a, std::string_view b) {
  const auto letter = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  std::vector<size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) above[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const bool is_same = letter(a[i - 1]) == letter(b[j - 1]);
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (is_same ? 0 : 1)});
      if (i > 1 && j > 1 && letter(a[i - 1]) == letter(b[j - 2]) && letter(a[i - 2]) == letter(b[j - 1]))
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, above);
    std::swap(above, row);
  }
  return above[b.size()];
}

/// "; did you mean NAME or NAME?" with up to three of `names` that `word` may have meant, nearest first:
/// those that differ in up to a third of its letters, that it begins, or that it is part of. Empty if there
/// are none.
inline std::string suggest(std::string_view word, const std::vector<std::string>& names) {
  constexpr size_t MOST_NAMES = 3, MOST_LETTERS = 64;
  if (word.empty() || word.size() > MOST_LETTERS) return {};
  const size_t tolerated = std::max<size_t>(1, word.size() / 3);
  std::vector<std::pair<size_t, std::string>> near;
  for (const std::string& name : names) {
    if (name.size() > MOST_LETTERS) continue;
    const size_t distance = edit_distance(word, name);
    const bool is_near = distance <= tolerated && distance < std::max(word.size(), name.size());
    const bool is_part = word.size() >= 3 && name.find(word) != std::string::npos;
    if (is_near || is_part) near.emplace_back(is_near ? distance : tolerated + 1, name);
  }
  std::ranges::stable_sort(near, {}, &std::pair<size_t, std::string>::first);
  std::string text;
  for (size_t i = 0; i < std::min(near.size(), MOST_NAMES); ++i)
    text += (i == 0                                       ? "; did you mean "
             : i + 1 == std::min(near.size(), MOST_NAMES) ? " or "
                                                          : ", ") +
            near[i].second;
  return text.empty() ? text : text + "?";
}

/// `"word" is not one of a, b, c; did you mean b?`
inline std::string unknown_name(const std::string& word, const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return "\"" + word + "\" is not one of " + list + suggest(word, names);
}

}  // namespace regulus
