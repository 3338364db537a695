#include "pipeline/check/report_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "pipeline/base/printable.h"
#include "pipeline/contract/argument_words.h"

namespace thixo {
namespace {

/// Text for XML and HTML: what has a meaning there is written by its number. Control characters become \xNN, and so do
/// bytes where the text is no UTF-8.
std::string escaped(const std::string& text) {
    const bool utf8 = is_utf8(text);
    std::string out;
    for (const char c : printable(text)) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte >= 0x80 && !utf8)
            out += fmt::format("\\x{:02x}", byte);
        else if (std::string_view("<>&\"'").find(c) != std::string_view::npos)
            out += fmt::format("&#{};", byte);
        else
            out += c;
    }
    return out;
}

/// The address of a file that lies beside the page.
std::string address(const std::string& name) {
    std::string out;
    for (const char c : name) {
        const bool plain =
            std::isalnum(static_cast<unsigned char>(c)) || std::string_view("._-").find(c) != std::string_view::npos;
        out += plain ? std::string(1, c) : fmt::format("%{:02x}", static_cast<unsigned char>(c));
    }
    return out;
}

std::string joined(const FrameReport& f) { return escaped(fmt::format("{}", fmt::join(f.problems, "; "))); }

std::string picture_cells(const FrameReport& f) {
    if (!f.has_picture) return "<td></td><td></td><td></td>";
    return fmt::format("<td>{}</td><td>{:.4g}</td><td>{:.4g}</td>", f.picture.pixels_different, f.picture.rel_mse,
                       f.picture.max_abs);
}

std::string measure_cells(const FrameReport& f) {
    if (!f.measures) return "<td></td><td></td><td></td>";
    const PictureMeasures& m = *f.measures;
    return fmt::format("<td>{:.4g}</td><td>{:.5g}</td><td>{}</td>", m.flip, m.brightness,
                       m.flicker < 0 ? "" : fmt::format("{:.4g}", m.flicker));
}

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>thixo check</title>
<style>
body { font: 14px sans-serif; margin: 2em; color: #222; background: #fff }
table { border-collapse: collapse } td, th { padding: 2px 10px; text-align: right; border-bottom: 1px solid #ddd }
td:first-child, td:last-child, th:first-child, th:last-child { text-align: left }
.differs { background: #fdd } .damaged { background: #fc9 } img { max-width: 100%; image-rendering: pixelated }
</style></head><body>
)";

}  // namespace

std::string print_junit(const CheckReport& report) {
    const auto failures =
        std::ranges::count_if(report.frames, [](const FrameReport& f) { return !f.same() && !f.damaged; });
    const auto errors = std::ranges::count_if(report.frames, [](const FrameReport& f) { return f.damaged; });
    std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
    text += fmt::format("<testsuite name=\"thixo check {}\" tests=\"{}\" failures=\"{}\" errors=\"{}\">\n",
                        escaped(report.b), report.frames.size(), failures, errors);
    for (const FrameReport& f : report.frames) {
        text += fmt::format("  <testcase classname=\"{}\" name=\"{}\"", escaped(report.a), escaped(f.name));
        if (f.same())
            text += "/>\n";
        else
            text += fmt::format("><{0} message=\"{1}\"/></testcase>\n", f.damaged ? "error" : "failure", joined(f));
    }
    return text + "</testsuite>\n";
}

std::string print_html(const CheckReport& report) {
    std::string text = kHead;
    text += fmt::format("<h1>{}</h1>\n<p>{}<br>against {}</p>\n", escaped(summary(report)), escaped(report.a),
                        escaped(report.b));
    text +=
        "<table><tr><th>frame</th><th>pixels that differ</th><th>relMSE</th><th>largest</th><th>FLIP</th>"
        "<th>brightness</th><th>flicker</th><th>problems</th></tr>\n";
    for (const FrameReport& f : report.frames)
        text += fmt::format("<tr class=\"{}\"><td>{}</td>{}{}<td>{}</td></tr>\n",
                            f.damaged  ? "damaged"
                            : f.same() ? "same"
                                       : "differs",
                            escaped(f.name), picture_cells(f), measure_cells(f), joined(f));
    text += "</table>\n";
    for (const FrameReport& f : report.frames)
        if (!f.sheet_picture.empty())
            text += fmt::format(
                "<h2>{0}</h2>\n<p>A, the reference, and where they differ</p>\n<img src=\"{1}\" alt=\"{0}\">\n",
                escaped(f.name), address(f.sheet_picture));
    return text + "</body></html>\n";
}

}  // namespace thixo
