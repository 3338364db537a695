#include "pipeline/driver/film.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/ownership.h"
#include "pipeline/contract/picture_files.h"
#include "pipeline/driver/process.h"
#include "pipeline/driver/scratch_folder.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

// The film's comment: this, its checksum (of the film with zeros in its place), a blank, the checksum of what it shows.
constexpr std::string_view kMark = "thixo film ";
constexpr std::size_t kDigits = 32;

/// Pictures by frame number.
std::map<int, fs::path> pictures(const FilmPlan& plan) {
    std::map<int, fs::path> found;
    for (const int number : plan.numbers) {
        const fs::path path = png_path(plan.frames, number);
        std::error_code missing;
        if (fs::is_regular_file(path, missing)) found[number] = path;
    }
    return found;
}

/// Checksum of what a film shows.
std::string checksum_of(const std::map<int, fs::path>& pictures, const FilmPlan& plan) {
    std::string text = fmt::format("{} fps", plan.fps);
    if (plan.codec != Codec::h264) text += " " + kCodecs[static_cast<std::size_t>(plan.codec)];
    for (const auto& [number, picture] : pictures) text += fmt::format(" {}:{}", number, hash_hex(read_whole(picture)));
    return hash_hex(text);
}

/// Where the digits of a film's own checksum stand, or npos where it is not Thixo's.
std::size_t checksum_at(std::string_view film) {
    const std::size_t at = film.find(kMark);
    return at == film.npos || at + kMark.size() + 2 * kDigits + 1 > film.size() ? film.npos : at + kMark.size();
}

bool is_own_film(std::string_view film) { return checksum_at(film) != film.npos; }

/// The checksum of what an undamaged film shows; nothing where there is none.
std::optional<std::string> shown_by(const fs::path& film) {
    std::error_code missing;
    if (!fs::is_regular_file(film, missing)) return std::nullopt;
    const std::string bytes = read_whole(film);
    const std::size_t at = checksum_at(bytes);
    if (at == bytes.npos || bytes.substr(at, kDigits) != hash_hex_without(bytes, at, kDigits)) return std::nullopt;
    return bytes.substr(at + kDigits + 1, kDigits);
}

/// Links 000000.png, 000001.png, ... to the pictures, a gap filled by the picture before it.
void link_in_order(const std::map<int, fs::path>& pictures, const ScratchFolder& scratch) {
    int count = 0;
    for (int n = pictures.begin()->first; n <= pictures.rbegin()->first; ++n) {
        const fs::path& shown = std::prev(pictures.upper_bound(n))->second;
        const fs::path link = scratch.path() / fmt::format("{:06}.png", count++);
        std::error_code failure;
        fs::create_symlink(fs::absolute(shown), link, failure);
        if (failure)
            throw ResourceError("cannot write {}: {}; free space or choose another --out", link.string(),
                                failure.message());
    }
}

/// The words that choose an encoder. Each works on one thread and leaves out its version: equal pictures give equal
/// bytes.
std::vector<std::string> words_of(Codec codec) {
    switch (codec) {
        case Codec::h264:
            return {"-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "18"};
        case Codec::h265:  // players of Apple ask for the tag
            return {"-c:v",   "libx265", "-pix_fmt",     "yuv420p",
                    "-crf",   "22",      "-x265-params", "log-level=error:pools=none:frame-threads=1:info=0",
                    "-tag:v", "hvc1"};
        case Codec::prores:
            return {"-c:v", "prores_ks", "-profile:v", "hq", "-pix_fmt", "yuv422p10le", "-vendor", "apl0"};
    }
    return {};
}

/// Works within the folder of the links: in names of files ffmpeg takes % for a pattern, a colon for a protocol.
ProgramCall ffmpeg_call(const ScratchFolder& scratch, const FilmPlan& plan, const std::string& comment) {
    std::vector<std::string> words{
        "-hide_banner", "-loglevel", "error", "-nostdin", "-y", "-framerate", fmt::format("{:.9g}", plan.fps), "-i",
        "%06d.png",
        // even size for yuv420p; display pictures are full-range RGB, film is limited-range Rec.709
        "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv"};
    for (std::string& word : words_of(plan.codec)) words.push_back(std::move(word));
    for (const char* word : {"-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-threads",
                             "1", "-map_metadata", "-1", "-metadata"})
        words.emplace_back(word);
    words.push_back("comment=" + comment);
    const char* const container = plan.codec == Codec::prores ? "mov" : "mp4";
    for (const char* word :
         {"-fflags", "+bitexact", "-flags:v", "+bitexact", "-movflags", "+faststart", "-f", container, "film"})
        words.emplace_back(word);
    return {"ffmpeg", "ffmpeg", std::move(words), scratch.path()};
}

}  // namespace

Codec parse_codec(const std::string& word) {
    const auto at = std::ranges::find(kCodecs, word);
    if (at == kCodecs.end()) throw InputError("there is no codec '{}'; there are {}", word, fmt::join(kCodecs, ", "));
    return static_cast<Codec>(at - kCodecs.begin());
}

std::string film_ending(Codec codec) { return codec == Codec::prores ? ".mov" : ".mp4"; }

void require_ffmpeg() {
    const char* path = std::getenv("PATH");
    std::string_view rest = path ? path : "";
    while (!rest.empty()) {
        const std::size_t end = std::min(rest.find(':'), rest.size());
        if (access((fs::path(rest.substr(0, end)) / "ffmpeg").c_str(), X_OK) == 0) return;
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    throw InputError(
        "ffmpeg is not installed, which makes the film; install it, or leave the film of a run out with "
        "--set look.output.film=false");
}

bool film_is_whole(const fs::path& film) { return shown_by(film).has_value(); }

bool film_is_current(const FilmPlan& plan, const fs::path& film) {
    const std::optional<std::string> shown = shown_by(film);
    if (!shown) return false;
    const std::map<int, fs::path> there = pictures(plan);
    const fs::file_time_type made = fs::last_write_time(film);
    for (const auto& [number, picture] : there)
        if (fs::last_write_time(picture) > made) return false;
    return *shown == checksum_of(there, plan);
}

void make_film(const FilmPlan& plan, const fs::path& film) {
    const std::map<int, fs::path> shown = pictures(plan);
    if (shown.empty())
        throw CacheError("{} holds no beauty.NNNN.png to make a film of; render first", plan.frames.string());
    require_own(film, is_own_film);
    const ScratchFolder scratch(film.parent_path(), "film");
    link_in_order(shown, scratch);
    const std::string comment = fmt::format("{}{} {}", kMark, std::string(kDigits, '0'), checksum_of(shown, plan));

    Process ffmpeg = start(ffmpeg_call(scratch, plan, comment), {.out = false, .err = true});
    std::deque<std::string> last_words;
    Process* const all[] = {&ffmpeg};
    while (!ffmpeg.status)
        wait_a_moment(all, [&](Process&, bool, const std::string& line) {
            last_words.push_back(line);
            if (last_words.size() > 5) last_words.pop_front();
        });
    if (const int number = interrupted()) throw InterruptedError(number);
    if (exit_code(ffmpeg) != 0) {
        std::string text;
        for (const std::string& line : last_words) text += "\n  " + line;
        const bool full = text.find("No space left") != std::string::npos;
        if (full)
            throw ResourceError("no space left for {}; the frames are complete: free space, the same command encodes{}",
                                film.string(), text);
        throw InputError("ffmpeg could not encode {}; the frames are complete{}", film.string(), text);
    }
    std::string bytes = read_whole(scratch.path() / "film");
    const std::size_t at = checksum_at(bytes);
    if (at == bytes.npos) throw InputError("ffmpeg made {} without its comment; install another ffmpeg", film.string());
    bytes.replace(at, kDigits, hash_hex(bytes));
    write_whole(film, bytes);
}

void update_film(const FilmPlan& plan, const fs::path& film) {
    remove_stale_temporaries(film.parent_path());
    if (film_is_current(plan, film)) return;
    log_info("encoding {}", film.string());
    make_film(plan, film);
}

}  // namespace thixo
