// Reads words and numbers from text in memory and counts lines for messages. Lines end with LF, CR LF or CR.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "pipeline/base/error.h"

namespace thixo {

/// A file's bytes behind the byte order mark of UTF-8, where it has one. Throws InputError on one of UTF-16, whose
/// letters no reader here knows.
inline std::string_view without_byte_order_mark(std::string_view bytes, const std::string& file) {
    using namespace std::string_view_literals;
    if (bytes.starts_with("\xef\xbb\xbf"sv)) return bytes.substr(3);
    if (bytes.starts_with("\xff\xfe"sv) || bytes.starts_with("\xfe\xff"sv))
        throw InputError("{}: line 1: the text is UTF-16; save it as ASCII or UTF-8", file);
    return bytes;
}

class TextCursor {
  public:
    TextCursor(std::string_view text, const std::string& file, std::size_t first_line = 1)
        : text_(text), file_(file), line_(first_line) {}

    /// The next word, after blanks and line ends; empty at the end of the text.
    std::string_view word() {
        skip_blanks(true);
        return take();
    }
    /// The next word of this line; empty at its end. A backslash at the end of a line joins the next line to it.
    std::string_view word_in_line() {
        skip_blanks(false);
        return take();
    }
    /// Goes past the end of this line; false at the end of the text.
    bool next_line() {
        while (at_ < text_.size() && !ends_line(text_[at_])) ++at_;
        if (at_ == text_.size()) return false;
        skip_line_end();
        return true;
    }
    bool at_end() const { return at_ >= text_.size(); }
    std::size_t line() const { return line_; }
    std::size_t position() const { return at_; }
    std::size_t left() const { return text_.size() - at_; }

    /// Throws InputError unless the word is a finite number.
    double number(std::string_view word) const {
        double value = 0;
        if (!word.empty() && word[0] == '+') word.remove_prefix(1);
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error == std::errc::result_out_of_range && !word.empty()) return out_of_range(word);
        if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
            fail("'{}' is not a finite number", shown(word));
        return value;
    }
    double coordinate(std::string_view word) const {
        const double value = number(word);
        if (std::abs(value) > 1e30) fail("coordinate {} is too large", value);
        return value;
    }
    std::int64_t integer(std::string_view word) const {
        std::int64_t value = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc() || end != word.data() + word.size()) fail("'{}' is not a whole number", shown(word));
        return value;
    }

    template <class... A>
    [[noreturn]] void fail(fmt::format_string<A...> f, A&&... a) const {
        throw InputError("{}: line {}: {}; the file is damaged or of another format: export it again", file_, line_,
                         fmt::format(f, std::forward<A>(a)...));
    }
    /// The word as messages show it: printable and short.
    static std::string shown(std::string_view word) {
        std::string text(word.substr(0, 24));
        for (char& c : text)
            if (c < 32 || c > 126) c = '?';
        return text;
    }

  private:
    static bool blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
    static bool ends_line(char c) { return c == '\n' || c == '\r'; }

    void skip_line_end() {
        if (text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n') ++at_;
        ++at_, ++line_;
    }
    void skip_blanks(bool over_lines) {
        while (at_ < text_.size()) {
            const char c = text_[at_];
            if (blank(c)) {
                ++at_;
            } else if (ends_line(c) && over_lines) {
                skip_line_end();
            } else if (c == '\\' && !over_lines && at_ + 1 < text_.size() && ends_line(text_[at_ + 1])) {
                ++at_;
                skip_line_end();
            } else {
                return;
            }
        }
    }
    std::string_view take() {
        const std::size_t begin = at_;
        while (at_ < text_.size() && !blank(text_[at_]) && !ends_line(text_[at_])) ++at_;
        return text_.substr(begin, at_ - begin);
    }
    /// from_chars reports numbers that are too small (1e-400) in the same way as those that are too large.
    double out_of_range(std::string_view word) const {
        const auto e = word.find_first_of("eE");
        if (e != std::string_view::npos && e + 1 < word.size() && word[e + 1] == '-') return 0;
        fail("'{}' is not a finite number", shown(word));
    }

    std::string_view text_;
    const std::string& file_;
    std::size_t at_ = 0, line_;
};

}  // namespace thixo
