// Radiance HDR (Ward 1991): scan lines of 8-bit mantissas with a common exponent, packed by run lengths.
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/contract/image.h"

namespace thixo {
namespace {

constexpr double kMostHdrPixels = 1 << 28;
constexpr double kLargestHdrShrink = 1100;                   // bytes of memory that a byte of a file may ask for
constexpr int kShortestPacked = 8, kLongestPacked = 0x7fff;  // scan lines whose components are packed apart
// Red, green, blue, as x and y. Radiance's own primaries differ from Rec.709 by 0.01, and its white, which does not
// count here, by 0.02.
constexpr std::array<double, 6> kRec709{0.64, 0.33, 0.30, 0.60, 0.15, 0.06};
constexpr double kNearRec709 = 0.011;

using Rgbe = std::array<std::uint8_t, 4>;

/// How pixels are stored: scan lines along one axis, in the order of the other.
struct Layout {
    int lines = 0, length = 0;
    bool along_x = true;                        // the scan lines
    bool lines_turned = false, turned = false;  // they begin at the bottom or at the right; each ends at its start
    int width() const { return along_x ? length : lines; }
    int height() const { return along_x ? lines : length; }
    std::size_t place(int line, int k) const {
        const int a = lines_turned ? lines - 1 - line : line, b = turned ? length - 1 - k : k;
        const int x = along_x ? b : a, y = along_x ? a : b;
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width()) + static_cast<std::size_t>(x);
    }
};

class HdrReader {
  public:
    HdrReader(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {
        if (!bytes_.starts_with("#?")) damaged("it does not begin with #?");
        read_header();
        read_layout();
    }

    const Layout& layout() const { return layout_; }

    Image image() {
        const double pixels = double(layout_.lines) * double(layout_.length);
        if (pixels > kMostHdrPixels || 3 * sizeof(float) * pixels / kLargestHdrShrink > double(bytes_.size()))
            damaged("it is too short for its size in pixels");
        Image image(layout_.width(), layout_.height());
        for (const char* name : {"R", "G", "B"}) image.add(name, false);
        std::vector<Rgbe> line(static_cast<std::size_t>(layout_.length));
        for (int k = 0; k < layout_.lines; ++k) {
            read_line(line);
            for (int i = 0; i < layout_.length; ++i)
                store(line[static_cast<std::size_t>(i)], image, layout_.place(k, i));
        }
        return image;
    }

  private:
    [[noreturn]] void damaged(const std::string& why) const {
        throw CacheError("'{}' is damaged or not a Radiance HDR: {}", file_, why);
    }

    std::string_view next_line() {
        const std::size_t end = bytes_.find('\n', at_);
        if (end == std::string_view::npos) damaged("its header has no end");
        std::string_view line = bytes_.substr(at_, end - at_);
        at_ = end + 1;
        if (line.ends_with('\r')) line.remove_suffix(1);
        return line;
    }

    /// The numbers of a header line, exactly `count`.
    template <std::size_t Count>
    std::array<double, Count> numbers(std::string_view text) const {
        std::array<double, Count> result{};
        for (double& number : result) {
            text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
            const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
            if (failure != std::errc() || !std::isfinite(number)) damaged("a number of its header is none");
            text.remove_prefix(static_cast<std::size_t>(end - text.data()));
        }
        return result;
    }

    void divide_by(double factor, std::size_t colour) {
        if (!(factor > 0)) damaged("its exposure is not above 0");
        scale_[colour] /= factor;
    }

    void read_header() {
        bool is_rgbe = false;
        for (std::string_view line = next_line(); !line.empty(); line = next_line()) {
            const auto value = [&](std::string_view key) -> std::optional<std::string_view> {
                if (!line.starts_with(key)) return std::nullopt;
                return line.substr(key.size());
            };
            if (const auto format = value("FORMAT=")) {
                if (*format != "32-bit_rle_rgbe") damaged("its pixels are not 32-bit_rle_rgbe");
                is_rgbe = true;
            } else if (const auto exposure = value("EXPOSURE=")) {
                for (std::size_t c = 0; c < 3; ++c) divide_by(numbers<1>(*exposure)[0], c);
            } else if (const auto correction = value("COLORCORR=")) {
                for (std::size_t c = 0; c < 3; ++c) divide_by(numbers<3>(*correction)[c], c);
            } else if (const auto primaries = value("PRIMARIES=")) {
                const auto given = numbers<6>(*primaries);
                for (std::size_t k = 0; k < given.size(); ++k)
                    if (std::abs(given[k] - kRec709[k]) > kNearRec709)
                        damaged("its PRIMARIES are not those of Rec.709; convert it");
            }
        }
        if (!is_rgbe) damaged("it does not state its FORMAT");
    }

    /// "-Y 512 +X 1024": 512 scan lines from the top, of 1024 pixels from the left.
    void read_layout() {
        std::string_view line = next_line();
        const auto axis = [&](char& sign, char& name) {
            line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
            int count = 0;
            const std::size_t begin =
                std::min(line.find_first_not_of(' ', std::min<std::size_t>(2, line.size())), line.size());
            const auto [end, failure] = std::from_chars(line.data() + begin, line.data() + line.size(), count);
            if (line.size() < 4 || failure != std::errc() || count < 1) damaged("it does not state its size");
            sign = line[0];
            name = line[1];
            line.remove_prefix(static_cast<std::size_t>(end - line.data()));
            return count;
        };
        char sign1 = 0, sign2 = 0, name1 = 0, name2 = 0;
        layout_.lines = axis(sign1, name1);
        layout_.length = axis(sign2, name2);
        const auto is_sign = [](char c) { return c == '+' || c == '-'; };
        if (!is_sign(sign1) || !is_sign(sign2) || !((name1 == 'Y' && name2 == 'X') || (name1 == 'X' && name2 == 'Y')))
            damaged("it does not state its size");
        layout_.along_x = name2 == 'X';
        // Its y goes up, that of pictures goes down.
        layout_.lines_turned = sign1 == (name1 == 'Y' ? '+' : '-');
        layout_.turned = sign2 == (name2 == 'Y' ? '+' : '-');
    }

    std::uint8_t byte() {
        if (at_ >= bytes_.size()) damaged("it ends early");
        return static_cast<std::uint8_t>(bytes_[at_++]);
    }
    Rgbe pixel() {
        Rgbe p{};
        for (std::uint8_t& b : p) b = byte();
        return p;
    }

    void read_line(std::vector<Rgbe>& line) {
        const Rgbe first = pixel();
        const auto length = static_cast<int>(line.size());
        const bool packed = first[0] == 2 && first[1] == 2 && first[2] < 128;
        if (!packed || length < kShortestPacked || length > kLongestPacked) {
            at_ -= first.size();
            return read_flat(line);
        }
        if ((first[2] << 8 | first[3]) != length) damaged("a scan line has another length");
        for (std::size_t component = 0; component < 4; ++component) read_component(line, component);
    }

    /// One component of a line: runs of up to 127 equal bytes, and up to 128 bytes as they are.
    void read_component(std::vector<Rgbe>& line, std::size_t component) {
        for (std::size_t k = 0; k < line.size();) {
            const std::uint8_t code = byte();
            const bool run = code > 128;
            const std::size_t count = run ? code - 128u : code;
            if (count == 0 || count > line.size() - k) damaged("a run leaves its scan line");
            const std::uint8_t value = run ? byte() : std::uint8_t(0);
            for (const std::size_t end = k + count; k < end; ++k) line[k][component] = run ? value : byte();
        }
    }

    /// Pixels one by one. 1 1 1 n stands for n more of the one before; several of them give n from its low byte on.
    void read_flat(std::vector<Rgbe>& line) {
        int shift = 0;
        for (std::size_t k = 0; k < line.size();) {
            const Rgbe p = pixel();
            if (p[0] != 1 || p[1] != 1 || p[2] != 1) {
                line[k++] = p;
                shift = 0;
                continue;
            }
            const std::size_t count = shift < 32 ? static_cast<std::size_t>(p[3]) << shift : 0;
            if (k == 0 || count == 0 || count > line.size() - k) damaged("a run leaves its scan line");
            for (const std::size_t end = k + count; k < end; ++k) line[k] = line[k - 1];
            shift += 8;
        }
    }

    /// Red, for example, is (R + 1/2) 2^(E - 136), the middle of what was rounded to R; black where E is 0.
    void store(const Rgbe& p, Image& image, std::size_t place) const {
        const double unit = p[3] == 0 ? 0 : std::ldexp(1.0, p[3] - 136);
        for (std::size_t c = 0; c < 3; ++c)
            image.channels[c].values[place] = static_cast<float>((p[c] + 0.5) * unit * scale_[c]);
    }

    std::string_view bytes_;
    const std::string& file_;
    std::size_t at_ = 0;
    Layout layout_;
    std::array<double, 3> scale_{1, 1, 1};
};

}  // namespace

Image decode_hdr(std::string_view bytes, const std::string& file) { return HdrReader(bytes, file).image(); }

double hdr_pixels(std::string_view bytes, const std::string& file) {
    const Layout layout = HdrReader(bytes, file).layout();
    return double(layout.lines) * double(layout.length);
}

}  // namespace thixo
