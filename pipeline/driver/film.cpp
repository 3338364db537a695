#include "pipeline/driver/film.h"

#include <fmt/format.h>
#include <unistd.h>

#include <charconv>
#include <cstdlib>
#include <deque>
#include <map>
#include <string>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/driver/process.h"
#include "pipeline/driver/scratch_folder.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

/// Pictures by frame number.
std::map<int, fs::path> pictures(const fs::path& frames) {
    constexpr std::string_view head = "beauty.", tail = ".png";
    std::map<int, fs::path> found;
    std::error_code failure;
    for (const fs::directory_entry& entry : fs::directory_iterator(frames, failure)) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(head) || !name.ends_with(tail) || name.size() <= head.size() + tail.size()) continue;
        const char* const last = name.data() + name.size() - tail.size();
        int number = 0;
        if (const auto [end, bad] = std::from_chars(name.data() + head.size(), last, number);
            bad == std::errc() && end == last)
            found[number] = entry.path();
    }
    return found;
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

/// Works within the folder of the links: in names of files ffmpeg takes % for a pattern, a colon for a protocol.
ProgramCall ffmpeg_call(const ScratchFolder& scratch, double fps) {
    const std::string rate = fmt::format("{:.9g}", fps);
    return {"ffmpeg",
            "ffmpeg",
            {"-hide_banner", "-loglevel", "error", "-nostdin", "-y", "-framerate", rate, "-i", "%06d.png",
             // even size for yuv420p; display pictures are full-range RGB, film is limited-range Rec.709
             "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv", "-c:v", "libx264",
             "-pix_fmt", "yuv420p", "-crf", "18", "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc",
             "bt709",
             // one thread and no dates or versions: equal pictures give equal bytes
             "-threads", "1", "-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact", "-movflags",
             "+faststart", "-f", "mp4", "film.mp4"},
            scratch.path()};
}

}  // namespace

void require_ffmpeg() {
    const char* path = std::getenv("PATH");
    std::string_view rest = path ? path : "";
    while (!rest.empty()) {
        const std::size_t end = std::min(rest.find(':'), rest.size());
        if (access((fs::path(rest.substr(0, end)) / "ffmpeg").c_str(), X_OK) == 0) return;
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    throw InputError(
        "ffmpeg is not installed, which makes the film; install it, or leave the film out with --set "
        "look.output.film=false");
}

bool film_is_stale(const fs::path& frames, const fs::path& film) {
    std::error_code missing;
    const fs::file_time_type made = fs::last_write_time(film, missing);
    if (missing) return true;
    for (const auto& [number, picture] : pictures(frames))
        if (fs::last_write_time(picture) > made) return true;
    return false;
}

void make_film(const fs::path& frames, const fs::path& film, double fps) {
    const std::map<int, fs::path> shown = pictures(frames);
    if (shown.empty()) throw CacheError("{} holds no beauty.NNNN.png to make a film of; render first", frames.string());
    const ScratchFolder scratch(film.parent_path() / ".film");
    link_in_order(shown, scratch);

    Process ffmpeg = start(ffmpeg_call(scratch, fps), {.out = false, .err = true});
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
    write_whole(film, read_whole(scratch.path() / "film.mp4"));
}

}  // namespace thixo
