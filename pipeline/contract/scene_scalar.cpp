#include "pipeline/contract/scene_scalar.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace thixo::scene {
namespace {

bool digit(char c) { return c >= '0' && c <= '9'; }

std::size_t digits_from(std::string_view text, std::size_t begin) {
    std::size_t end = begin;
    while (end < text.size() && digit(text[end])) ++end;
    return end - begin;
}

struct Form {
    bool number = false, whole = false, leading_zero = false;
};

// [sign] digits [. digits] [e [sign] digits], with a digit before or behind the point.
Form form_of(std::string_view text) {
    Form form;
    std::size_t k = !text.empty() && (text[0] == '-' || text[0] == '+') ? 1 : 0;
    const std::size_t before = digits_from(text, k);
    form.leading_zero = before > 1 && text[k] == '0';
    k += before;
    std::size_t behind = 0;
    form.whole = true;
    if (k < text.size() && text[k] == '.') {
        form.whole = false;
        behind = digits_from(text, k + 1);
        k += 1 + behind;
    }
    if (before + behind == 0) return {};
    if (k < text.size() && (text[k] == 'e' || text[k] == 'E')) {
        form.whole = false;
        ++k;
        if (k < text.size() && (text[k] == '-' || text[k] == '+')) ++k;
        const std::size_t exponent = digits_from(text, k);
        if (exponent == 0) return {};
        k += exponent;
    }
    form.number = k == text.size();
    form.whole = form.whole && form.number;
    return form;
}

// Why a text is no number, where there is something to say about it.
std::string number_hint(const Value& value) {
    if (value.type != Value::Type::scalar) return {};
    const std::string& t = value.text;
    if (value.quoted && form_of(t).number) return "without the quotes it is a number";
    if (form_of(t).leading_zero) return "without the leading zero it is a decimal number";
    if (t.starts_with("0x") || t.starts_with("0X") || t.starts_with("0o")) return "only decimal numbers are read";
    if (t.find(',') != std::string::npos) return "the decimal sign is a point";
    std::string joined = t;
    joined.erase(std::remove(joined.begin(), joined.end(), '_'), joined.end());
    if (joined != t && form_of(joined).number) return "write the digits without _";
    if (t == ".nan" || t == ".inf" || t == "-.inf" || t == "nan" || t == "inf") return "only finite numbers are read";
    const std::size_t unit = t.find_first_not_of("+-0123456789.eE ");
    if (unit != std::string::npos && unit > 0 && digit(t[0])) return "write the number alone; units are fixed (SI)";
    return {};
}

template <class T>
Scalar<T> whole(const Value& value) {
    Scalar<T> result;
    if (value.type != Value::Type::scalar) return result;
    std::string_view text = value.text;
    const Form form = form_of(text);
    if (value.quoted || !form.number || form.leading_zero) return {{}, number_hint(value)};
    if (!form.whole) return {{}, "no point and no exponent"};
    if (text[0] == '+') text.remove_prefix(1);
    T number{};
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (failure == std::errc() && end == text.data() + text.size()) result.value = number;
    return result;
}

}  // namespace

Scalar<double> to_number(const Value& value) {
    if (value.type != Value::Type::scalar) return {};
    std::string_view text = value.text;
    const Form form = form_of(text);
    if (value.quoted || !form.number || form.leading_zero) return {{}, number_hint(value)};
    if (text[0] == '+') text.remove_prefix(1);
    double number = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (failure != std::errc() || end != text.data() + text.size() || !std::isfinite(number))
        return {{}, "too large or too small for a number"};
    return {number, {}};
}

Scalar<std::int64_t> to_whole(const Value& value) { return whole<std::int64_t>(value); }
Scalar<std::uint64_t> to_unsigned(const Value& value) { return whole<std::uint64_t>(value); }

Scalar<bool> to_truth(const Value& value) {
    if (value.type != Value::Type::scalar) return {};
    if (!value.quoted && value.text == "true") return {true, {}};
    if (!value.quoted && value.text == "false") return {false, {}};
    std::string lower = value.text;
    for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if (lower == "yes" || lower == "on" || lower == "y" || lower == "true" || lower == "1") return {{}, "write true"};
    if (lower == "no" || lower == "off" || lower == "n" || lower == "false" || lower == "0") return {{}, "write false"};
    return {};
}

}  // namespace thixo::scene
