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

FilmPlan plan_of(const TemporaryFolder& folder, std::vector<int> numbers, double fps = 24) {
    return {folder.path / "frames", std::move(numbers), fps};
}

/// The value that ffprobe gives for one property of the film's picture stream.
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
    make_film(plan_of(folder, {3, 4, 5, 6, 7, 8}), folder.path / "a.mp4");
    EXPECT_EQ("6", probed(folder.path / "a.mp4", "nb_read_frames"));
    EXPECT_EQ("24/1", probed(folder.path / "a.mp4", "r_frame_rate"));
    EXPECT_EQ("64,36", probed(folder.path / "a.mp4", "width,height"));
    EXPECT_EQ("yuv420p", probed(folder.path / "a.mp4", "pix_fmt"));
    EXPECT_EQ(2, std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()));  // and no scratch
}

TEST(Film, AGapIsHeldByThePictureBefore) {
    const TemporaryFolder folder;
    for (const int n : {1, 3, 5}) write_picture(folder.path / "frames", n, 64, 36, 50 * n);
    make_film(plan_of(folder, {1, 2, 3, 4, 5}, 25), folder.path / "a.mp4");
    EXPECT_EQ("5", probed(folder.path / "a.mp4", "nb_read_frames"));
}

TEST(Film, EqualPicturesGiveEqualBytes) {
    const TemporaryFolder folder;
    for (int n = 1; n <= 5; ++n) write_picture(folder.path / "frames", n, 64, 36, 40 * n);
    make_film(plan_of(folder, {1, 2, 3, 4, 5}), folder.path / "a.mp4");
    fs::rename(folder.path / "frames", folder.path / "other frames");
    make_film({folder.path / "other frames", {1, 2, 3, 4, 5}, 24}, folder.path / "b.mp4");
    EXPECT_EQ(text_of(folder.path / "a.mp4"), text_of(folder.path / "b.mp4"));
}

TEST(Film, IsMadeInAFolderOfAnyName) {
    const TemporaryFolder folder;
    for (const char* name : {"100%d off", "50%%", "%06d", "c:foo", "file:x", "-o", "a'b \"c\"", "pipe:1", "ü*?[1]"}) {
        const fs::path out = folder.path / name;
        for (int n = 1; n <= 2; ++n) write_picture(out / "frames", n, 64, 36, 40 * n);
        make_film({out / "frames", {1, 2}, 24}, out / (std::string(name) + ".mp4"));
        fs::copy_file(out / (std::string(name) + ".mp4"), folder.path / "plain.mp4",
                      fs::copy_options::overwrite_existing);
        EXPECT_EQ("2", probed(folder.path / "plain.mp4", "nb_read_frames")) << name;
    }
}

TEST(Film, IsOfTheCodecThatIsAskedForAndHasTheSameBytesAgain) {
    const TemporaryFolder folder;
    for (int n = 1; n <= 4; ++n) write_picture(folder.path / "frames", n, 64, 36, 40 * n);
    const std::vector<std::string> names{"h264", "hevc", "prores"}, formats{"yuv420p", "yuv420p", "yuv422p10le"};
    for (std::size_t k = 0; k < kCodecs.size(); ++k) {
        FilmPlan plan = plan_of(folder, {1, 2, 3, 4});
        plan.codec = parse_codec(kCodecs[k]);
        const fs::path film = folder.path / ("film" + film_ending(plan.codec));
        make_film(plan, film);
        EXPECT_EQ(names[k], probed(film, "codec_name"));
        EXPECT_EQ(formats[k], probed(film, "pix_fmt"));
        EXPECT_EQ("4", probed(film, "nb_read_frames"));
        EXPECT_TRUE(film_is_current(plan, film));
        FilmPlan other = plan;
        other.codec = static_cast<Codec>((k + 1) % kCodecs.size());
        EXPECT_FALSE(film_is_current(other, film)) << kCodecs[k];
        const std::string bytes = text_of(film);
        make_film(plan, film);
        EXPECT_EQ(bytes, text_of(film)) << kCodecs[k];
    }
    EXPECT_THROW(parse_codec("mpeg1"), InputError);
}

TEST(Film, TheIndexStandsInFront) {
    const TemporaryFolder folder;
    write_picture(folder.path / "frames", 1, 64, 36, 100);
    make_film(plan_of(folder, {1}), folder.path / "a.mp4");
    const std::string bytes = text_of(folder.path / "a.mp4");
    ASSERT_NE(std::string::npos, bytes.find("moov"));
    EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
}

TEST(Film, IsCurrentOnlyWhereUndamagedAndOfTheVeryPictures) {
    const TemporaryFolder folder;
    const fs::path film = folder.path / "a.mp4";
    for (const int n : {1, 2}) write_picture(folder.path / "frames", n, 16, 16, 9 * n);
    const FilmPlan plan = plan_of(folder, {1, 2});
    EXPECT_FALSE(film_is_current(plan, film));
    make_film(plan, film);
    EXPECT_TRUE(film_is_current(plan, film));
    EXPECT_FALSE(film_is_current(plan_of(folder, {1, 2}, 25), film));
    EXPECT_FALSE(film_is_current(plan_of(folder, {1}), film));

    const std::string bytes = text_of(film);
    for (std::size_t k = 0; k < 20; ++k) {
        std::string damaged = bytes;
        damaged[k * (bytes.size() - 1) / 19] ^= 4;
        std::ofstream(film, std::ios::binary) << damaged;
        EXPECT_FALSE(film_is_current(plan, film)) << k;
        std::ofstream(film, std::ios::binary) << bytes.substr(0, k * bytes.size() / 20);
        EXPECT_FALSE(film_is_current(plan, film)) << k;
    }
    std::ofstream(film, std::ios::trunc);  // an empty film is made again, to the same bytes
    make_film(plan, film);
    EXPECT_EQ(bytes, text_of(film));
    write_picture(folder.path / "frames", 2, 16, 16, 200);
    EXPECT_FALSE(film_is_current(plan, film));
}

TEST(Film, ShowsTheFramesOfTheCacheAndNoStrayPicture) {
    const TemporaryFolder folder;
    for (const int n : {1, 2, 200000}) write_picture(folder.path / "frames", n, 16, 16, n % 250);
    make_film(plan_of(folder, {1, 2, 3}), folder.path / "a.mp4");
    EXPECT_EQ("2", probed(folder.path / "a.mp4", "nb_read_frames"));
}

TEST(Film, AnotherProgramsFilmIsRefusedAndStays) {
    const TemporaryFolder folder;
    write_picture(folder.path / "frames", 1, 16, 16, 100);
    std::ofstream(folder.path / "a.mp4") << "mine";
    try {
        make_film(plan_of(folder, {1}), folder.path / "a.mp4");
        FAIL() << "no error";
    } catch (const InputError& e) {
        EXPECT_NE(std::string::npos, std::string(e.what()).find("a.mp4")) << e.what();
    }
    EXPECT_EQ("mine", text_of(folder.path / "a.mp4"));
}

TEST(Film, WithoutPicturesIsAClearError) {
    const TemporaryFolder folder;
    fs::create_directories(folder.path / "frames");
    EXPECT_THROW(make_film(plan_of(folder, {1}), folder.path / "a.mp4"), CacheError);
}

TEST(Film, ADamagedPictureLeavesTheFormerFilm) {
    const TemporaryFolder folder;
    write_picture(folder.path / "frames", 1, 64, 36, 100);
    make_film(plan_of(folder, {1}), folder.path / "a.mp4");
    const std::string before = text_of(folder.path / "a.mp4");
    std::ofstream(folder.path / "frames" / "beauty.0001.png") << "no picture";
    EXPECT_THROW(make_film(plan_of(folder, {1}), folder.path / "a.mp4"), InputError);
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
