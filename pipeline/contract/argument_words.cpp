#include "pipeline/contract/argument_words.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>

#include "pipeline/base/error.h"

namespace thixo {
namespace {

/// The whole word as a number of type T; nothing where it is none, or has no place in T.
template <class T>
std::optional<T> number_of(const std::string& word) {
    T number{};
    const char* const end = word.data() + word.size();
    const auto [stop, failure] = std::from_chars(word.data(), end, number);
    if (failure != std::errc() || stop != end) return std::nullopt;
    return number;
}

CLI::Option* add_word(CLI::App& app, const char* option, const char* meaning,
                      std::function<void(const std::string&)> take) {
    // Not by CLI11's own conversions: they turn -1 into the largest number, and let nan pass through every range.
    return app.add_option_function<std::string>(option, take, meaning);
}

}  // namespace

void put(std::vector<std::string>& words, const char* name, const std::string& value) {
    words.push_back(fmt::format("--{}={}", name, value));
}

void put_if(std::vector<std::string>& words, const char* name, bool set) {
    if (set) words.push_back(fmt::format("--{}", name));
}

void put_text(std::vector<std::string>& words, const char* name, const std::string& value) {
    if (!value.empty()) put(words, name, value);
}

std::string shell_word(const std::string& word) {
    const std::string plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,:+@%";
    if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
    std::string text = "'";
    for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return text + "'";
}

void put_path(std::vector<std::string>& words, const std::string& path) {
    if (path.empty()) return;
    words.push_back("--");
    words.push_back(path);
}

void add_number(CLI::App& app, const char* option, double& value, NumberRange range, const char* meaning) {
    const auto take = [option, &value, range](const std::string& word) {
        const std::optional<double> number = number_of<double>(word);
        if (!number || !std::isfinite(*number) || *number < range.least || *number > range.most)
            throw InputError("{} '{}' is no number from {} to {}", option, word, range.least, range.most);
        value = *number;
    };
    add_word(app, option, meaning, take)->type_name("X");
}

void add_threads(CLI::App& app, int& threads) {
    static constexpr int kMost = 1024;
    const auto take = [&threads](const std::string& word) {
        const std::optional<int> number = number_of<int>(word);
        if (!number || *number < 0 || *number > kMost)
            throw InputError("--threads '{}' is no whole number from 0 to {}", word, kMost);
        threads = *number;
    };
    add_word(app, "--threads", "threads; every core when left out", take)->type_name("N");
}

void add_seed(CLI::App& app, std::optional<std::uint64_t>& seed) {
    const auto take = [&seed](const std::string& word) {
        seed = number_of<std::uint64_t>(word);
        if (!seed) throw InputError("--seed '{}' is no whole number from 0 to 18446744073709551615", word);
    };
    add_word(app, "--seed", "replaces the scene's solver.seed", take)->type_name("N");
}

bool is_utf8(std::string_view text) {
    for (std::size_t i = 0; i < text.size();) {
        const auto c = static_cast<unsigned char>(text[i]);
        const std::size_t more = c < 0x80 ? 0 : c < 0xc2 ? 4 : c < 0xe0 ? 1 : c < 0xf0 ? 2 : c < 0xf5 ? 3 : 4;
        if (more == 4 || i + more >= text.size()) return false;
        char32_t code = more == 0 ? c : c & (0x3f >> more);
        for (std::size_t k = 1; k <= more; ++k) {
            const auto next = static_cast<unsigned char>(text[i + k]);
            if (next >> 6 != 2) return false;
            code = code << 6 | (next & 0x3f);
        }
        if ((more == 2 && code < 0x800) || (more == 3 && (code < 0x10000 || code > 0x10ffff))) return false;
        if (code >= 0xd800 && code < 0xe000) return false;
        i += more + 1;
    }
    return true;
}

std::string parse_words(CLI::App& app, std::vector<std::string> words) {
    const auto options_end = std::find(words.begin(), words.end(), "--");
    if (std::any_of(words.begin(), options_end, [](const std::string& w) { return w == "-h" || w == "--help"; }))
        return app.help();
    std::reverse(words.begin(), words.end());  // CLI11 pops words from the back
    try {
        app.parse(std::move(words));
    } catch (const CLI::ParseError& e) {
        throw InputError("{}: {}; --help lists the arguments", app.get_name(), e.what());
    }
    for (const CLI::Option* option : app.get_options())
        for (const std::string& word : option->results())
            if (word.empty()) throw InputError("{}: {} is empty", app.get_name(), option->get_name());
    return {};
}

}  // namespace thixo
