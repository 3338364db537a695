// The film of a sequence of pictures, encoded by ffmpeg.
#pragma once

#include <filesystem>

namespace thixo {

/// Throws InputError where ffmpeg is not installed: asked before hours of work, not after.
void require_ffmpeg();

/// True where `film` is missing or older than a picture it should show.
bool film_is_stale(const std::filesystem::path& frames, const std::filesystem::path& film);

/// Encodes frames/beauty.NNNN.png as H.264 (yuv420p, Rec.709, even size, index in front) at `fps`, whole or not at all.
/// Where numbers are missing between the first and the last picture the one before stands still, so that time stays
/// right. Equal pictures give equal bytes with the same ffmpeg. Throws CacheError (no picture), ResourceError (disk),
/// InputError (ffmpeg refuses, with its last words).
void make_film(const std::filesystem::path& frames, const std::filesystem::path& film, double fps);

}  // namespace thixo
