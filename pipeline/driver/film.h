// The film of a sequence of pictures, encoded by ffmpeg.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace thixo {

/// h264: for every player; h265: smaller; prores: for cutting, 4:2:2 with 10 bits, far larger.
enum class Codec { h264, h265, prores };
inline const std::vector<std::string> kCodecs{"h264", "h265", "prores"};
/// Throws InputError for another word.
Codec parse_codec(const std::string& word);
/// The ending of a film's name, with its dot.
std::string film_ending(Codec codec);

/// What a film shows: those of frames/beauty.NNNN.png that have these numbers and exist.
struct FilmPlan {
    std::filesystem::path frames;
    std::vector<int> numbers;  // ascending; the cache's
    double fps = 24;
    Codec codec = Codec::h264;
};

/// Throws InputError where ffmpeg is not installed: asked before hours of work, not after.
void require_ffmpeg();

/// True where `film` is undamaged, not older than any picture, and was made from these very pictures at this rate. The
/// film tells: it carries its own checksum and that of what it shows.
bool film_is_current(const FilmPlan& plan, const std::filesystem::path& film);

/// True where `film` is there, is Thixo's, and has the bytes that its checksum states.
bool film_is_whole(const std::filesystem::path& film);

/// Encodes the pictures (Rec.709, even size, index in front), whole or not at all. In place of a
/// number that is missing the picture before is shown again, so that time stays right. Equal pictures give equal bytes
/// with the same ffmpeg. Throws CacheError (no picture), ResourceError (disk), or InputError: another program's file is
/// in the film's place, or ffmpeg refuses, with its last words.
void make_film(const FilmPlan& plan, const std::filesystem::path& film);

/// Makes the film where it is not current. Either way nothing stays of an encoding that was killed, be it after its film
/// was in place. Throws as make_film does.
void update_film(const FilmPlan& plan, const std::filesystem::path& film);

}  // namespace thixo
