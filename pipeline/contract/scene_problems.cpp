#include "pipeline/contract/scene_problems.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <tuple>

#include "pipeline/base/error.h"

namespace thixo::scene {
namespace {

constexpr std::size_t kKept = 1000, kShown = 50;
constexpr std::size_t kWidth = 160;  // bytes of a source line that are shown

std::string_view line_of(std::string_view text, int line) {
    for (int k = 1; k < line; ++k) {
        const std::size_t end = text.find('\n');
        if (end == std::string_view::npos) return {};
        text.remove_prefix(end + 1);
    }
    text = text.substr(0, text.find('\n'));
    if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
    return text;
}

bool starts_character(char byte) { return (static_cast<unsigned char>(byte) & 0xc0) != 0x80; }

std::size_t byte_of_character(std::string_view text, int character) {
    std::size_t byte = 0;
    for (; byte < text.size(); ++byte)
        if (starts_character(text[byte]) && character-- == 0) break;
    return byte;
}

// Optimal string alignment distance.
int edits(std::string_view a, std::string_view b) {
    std::vector<int> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) above[j] = static_cast<int>(j);
    for (std::size_t i = 1; i <= a.size(); ++i) {
        row[0] = static_cast<int>(i);
        for (std::size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (a[i - 1] != b[j - 1])});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before[j - 2] + 1);
        }
        std::swap(before, above);
        std::swap(above, row);
    }
    return above[b.size()];
}

}  // namespace

int characters(std::string_view text) {
    return static_cast<int>(std::count_if(text.begin(), text.end(), starts_character));
}

std::string shown(std::string_view text, int most) {
    std::string out;
    const std::size_t end = std::min(text.size(), byte_of_character(text, most));
    for (const char c : text.substr(0, end)) out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    return end < text.size() ? out + "..." : out;
}

std::string nearest_word(std::string_view word, const std::vector<std::string>& words) {
    if (word.size() > 40) return {};
    std::string best;
    int fewest = static_cast<int>(std::max<std::size_t>(1, word.size() / 3)) + 1;
    // Bounded: a file with thousands of wrong words must not take long.
    for (std::size_t k = 0; k < std::min<std::size_t>(words.size(), 200); ++k) {
        const std::string& candidate = words[k];
        if (std::abs(static_cast<int>(candidate.size()) - static_cast<int>(word.size())) >= fewest) continue;
        const int n = edits(word, candidate);
        if (n < fewest && n < static_cast<int>(candidate.size())) {
            fewest = n;
            best = candidate;
        }
    }
    return best;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& words) {
    if (words.empty()) return {};
    if (const std::string best = nearest_word(word, words); !best.empty())
        return fmt::format("did you mean \"{}\"?", best);
    const std::size_t listed = std::min<std::size_t>(words.size(), 24);
    return fmt::format("known: {}{}",
                       fmt::join(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(listed), ", "),
                       listed < words.size() ? ", ..." : "");
}

int Problems::add_source(Source source) {
    if (source.text.starts_with("\xef\xbb\xbf")) source.text.erase(0, 3);  // byte order mark
    // YAML permits lines that end with CR alone; its library does not.
    if (source.text.find('\n') == std::string::npos) std::ranges::replace(source.text, '\r', '\n');
    sources_.push_back(std::move(source));
    return static_cast<int>(sources_.size()) - 1;
}

void Problems::add(const Position& at, std::string message, std::string hint) {
    ++count_;
    if (problems_.size() < kKept) problems_.push_back({at, std::move(message), std::move(hint)});
}

std::string Problems::place(const Position& at) const {
    if (at.source < 0) return "scene";
    return at.line > 0 ? fmt::format("{}:{}:{}", source(at.source).name, at.line, at.column) : source(at.source).name;
}

std::string Problems::text(const Problem& problem) const {
    const Position& at = problem.at;
    std::string out = fmt::format("{}: error: {}\n", place(at), problem.message);
    if (at.source < 0 || at.line <= 0)
        return problem.hint.empty() ? out : out + fmt::format("         {}\n", problem.hint);
    std::string_view line = line_of(source(at.source).text, at.line);
    // Of a very long line the part around the place is shown.
    std::size_t place_byte = byte_of_character(line, at.column - 1);
    std::size_t skip = place_byte > kWidth - 40 ? place_byte - 40 : 0;
    while (skip > 0 && !starts_character(line[skip])) --skip;
    line.remove_prefix(skip);
    place_byte -= skip;
    std::size_t end = std::min(line.size(), kWidth);
    while (end > 0 && end < line.size() && !starts_character(line[end])) --end;
    line = line.substr(0, end);
    // Tabs are kept before the caret, so that it stands right whatever a tab's width.
    std::string before;
    for (const char c : line.substr(0, place_byte))
        if (starts_character(c)) before += c == '\t' ? '\t' : ' ';
    std::string printable(line);
    for (char& c : printable)
        if ((static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7f) c = ' ';
    const int room = characters(line.substr(std::min(place_byte, line.size())));
    const std::string carets(static_cast<std::size_t>(std::clamp(at.length, 1, std::max(room, 1))), '^');
    out += fmt::format("{:5} | {}\n", at.line, printable);
    out += fmt::format("      | {}{}{}{}\n", before, carets, problem.hint.empty() ? "" : " ", problem.hint);
    return out;
}

void Problems::throw_if_any(const std::string& what) const {
    if (!any()) return;
    std::vector<Problem> sorted = problems_;
    std::stable_sort(sorted.begin(), sorted.end(), [](const Problem& a, const Problem& b) {
        return std::tie(a.at.source, a.at.line, a.at.column) < std::tie(b.at.source, b.at.line, b.at.column);
    });
    std::string out = fmt::format("{}: {} error{}\n", what, count_, count_ == 1 ? "" : "s");
    for (std::size_t k = 0; k < std::min(sorted.size(), kShown); ++k) out += text(sorted[k]);
    if (count_ > kShown) out += fmt::format("... and {} more\n", count_ - kShown);
    out.pop_back();
    throw InputError("{}", out);
}

}  // namespace thixo::scene
