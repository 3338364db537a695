#include "pipeline/driver/film.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "pipeline/base/error.h"
#include "pipeline/contract/image.h"
#include "pipeline/driver/process.h"
#include "tests/pipeline/driver/temporary_folder.h"

namespace thixo {
namespace {
namespace fs = std::filesystem;

void write_picture(const fs::path& frames, int number, int width, int height, int grey) {
    Image8 image;
    image.width = width;
    image.height = height;
    image.values.assign(static_cast<std::size_t>(width * height * 3), static_cast<std::uint8_t>(grey));
    fs::create_directories(frames);
    char name[32];
    std::snprintf(name, sizeof name, "beauty.%04d.png", number);
    write_png(frames / name, image);
}

/// What ffprobe says of one property of the film's picture stream.
std::string probed(const fs::path& film, const std::string& property) {
    std::string out;
    run_to_end({"ffprobe",
                "ffprobe",
                {"-v", "error", "-count_frames", "-select_streams", "v:0", "-show_entries", "stream=" + property, "-of",
                 "csv=p=0", film.string()}},
               &out);
    while (!out.empty() && (out.back() == '\n' || out.back() == ',')) out.pop_back();
    return out;
}

TEST(Film, HasEveryPictureAtTheScenesRateAndAnEvenSize) {
    const TemporaryFolder folder;
    for (int n = 3; n <= 8; ++n) write_picture(folder.path / "frames", n, 63, 35, 40 * (n - 2));
    make_film(folder.path / "frames", folder.path / "a.mp4", 24);
    EXPECT_EQ("6", probed(folder.path / "a.mp4", "nb_read_frames"));
    EXPECT_EQ("24/1", probed(folder.path / "a.mp4", "r_frame_rate"));
    EXPECT_EQ("64,36", probed(folder.path / "a.mp4", "width,height"));
    EXPECT_EQ("yuv420p", probed(folder.path / "a.mp4", "pix_fmt"));
    EXPECT_FALSE(fs::exists(folder.path / ".film"));
}

TEST(Film, AGapIsHeldByThePictureBefore) {
    const TemporaryFolder folder;
    for (const int n : {1, 3, 5}) write_picture(folder.path / "frames", n, 64, 36, 50 * n);
    make_film(folder.path / "frames", folder.path / "a.mp4", 25);
    EXPECT_EQ("5", probed(folder.path / "a.mp4", "nb_read_frames"));
}

TEST(Film, EqualPicturesGiveEqualBytes) {
    const TemporaryFolder folder;
    for (int n = 1; n <= 5; ++n) write_picture(folder.path / "frames", n, 64, 36, 40 * n);
    make_film(folder.path / "frames", folder.path / "a.mp4", 24);
    fs::rename(folder.path / "frames", folder.path / "other frames");
    make_film(folder.path / "other frames", folder.path / "b.mp4", 24);
    EXPECT_EQ(text_of(folder.path / "a.mp4"), text_of(folder.path / "b.mp4"));
}

TEST(Film, IsMadeInAFolderOfAnyName) {
    const TemporaryFolder folder;
    for (const char* name : {"100%d off", "50%%", "%06d", "c:foo", "file:x", "-o", "a'b \"c\"", "pipe:1", "ü*?[1]"}) {
        const fs::path out = folder.path / name;
        for (int n = 1; n <= 2; ++n) write_picture(out / "frames", n, 64, 36, 40 * n);
        make_film(out / "frames", out / (std::string(name) + ".mp4"), 24);
        fs::copy_file(out / (std::string(name) + ".mp4"), folder.path / "plain.mp4",
                      fs::copy_options::overwrite_existing);
        EXPECT_EQ("2", probed(folder.path / "plain.mp4", "nb_read_frames")) << name;
    }
}

TEST(Film, TheIndexStandsInFront) {
    const TemporaryFolder folder;
    write_picture(folder.path / "frames", 1, 64, 36, 100);
    make_film(folder.path / "frames", folder.path / "a.mp4", 24);
    const std::string bytes = text_of(folder.path / "a.mp4");
    ASSERT_NE(std::string::npos, bytes.find("moov"));
    EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
}

TEST(Film, IsStaleWhenAPictureIsNewer) {
    const TemporaryFolder folder;
    const fs::path film = folder.path / "a.mp4";
    write_picture(folder.path / "frames", 1, 4, 4, 9);
    EXPECT_TRUE(film_is_stale(folder.path / "frames", film));
    std::ofstream(film) << "x";
    const auto picture_time = fs::last_write_time(folder.path / "frames" / "beauty.0001.png");
    fs::last_write_time(film, picture_time + std::chrono::seconds(1));
    EXPECT_FALSE(film_is_stale(folder.path / "frames", film));
    fs::last_write_time(film, picture_time - std::chrono::seconds(1));
    EXPECT_TRUE(film_is_stale(folder.path / "frames", film));
}

TEST(Film, WithoutPicturesIsAClearError) {
    const TemporaryFolder folder;
    fs::create_directories(folder.path / "frames");
    EXPECT_THROW(make_film(folder.path / "frames", folder.path / "a.mp4", 24), CacheError);
}

TEST(Film, ADamagedPictureLeavesTheFormerFilm) {
    const TemporaryFolder folder;
    write_picture(folder.path / "frames", 1, 64, 36, 100);
    make_film(folder.path / "frames", folder.path / "a.mp4", 24);
    const std::string before = text_of(folder.path / "a.mp4");
    std::ofstream(folder.path / "frames" / "beauty.0001.png") << "no picture";
    EXPECT_THROW(make_film(folder.path / "frames", folder.path / "a.mp4", 24), InputError);
    EXPECT_EQ(before, text_of(folder.path / "a.mp4"));
}

TEST(Film, AMissingEncoderIsSaidBeforeTheWork) {
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    EXPECT_NO_THROW(require_ffmpeg());
    EXPECT_EXIT(
        {
            setenv("PATH", "/nonexistent", 1);
            try {
                require_ffmpeg();
            } catch (const InputError&) {
                std::exit(42);
            }
            std::exit(0);
        },
        testing::ExitedWithCode(42), "");
}

}  // namespace
}  // namespace thixo
