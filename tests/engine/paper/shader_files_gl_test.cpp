// Shader texts as files: a compiler that is stricter than this machine's driver takes them all, and drivers that are chosen
// elsewhere read them from a folder.
#if defined(__unix__)
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <sstream>

#include <unistd.h>

#include "engine/paper/shader_texts.h"

namespace paradesc {
namespace {

using test::Program;
using test::recording;
using test::ShaderTexts;

// ---- Texts as files

std::string ending_of(GLenum stage) {
  return stage == GL_VERTEX_SHADER ? ".vert" : stage == GL_FRAGMENT_SHADER ? ".frag" : ".comp";
}

void write(const std::set<Program> &programs, const std::filesystem::path &folder) {
  std::filesystem::create_directories(folder);
  size_t number = 10000; // so that names have one length
  for (const Program &program : programs) {
    ++number;
    for (const auto &[stage, text] : program) std::ofstream(folder / (std::to_string(number) + ending_of(stage))) << text;
  }
}

// Programs by the name of their files.
std::map<std::string, Program> read(const std::filesystem::path &folder) {
  std::map<std::string, Program> programs;
  for (const auto &file : std::filesystem::directory_iterator(folder))
    for (const GLenum stage : {GL_VERTEX_SHADER, GL_FRAGMENT_SHADER, GL_COMPUTE_SHADER})
      if (file.path().extension() == ending_of(stage)) {
        std::ifstream text(file.path());
        programs[file.path().stem().string()][stage] = std::string(std::istreambuf_iterator<char>(text), {});
      }
  return programs;
}

// Returns the output of a command and its exit status.
std::pair<std::string, int> output_of(const std::string &command) {
  std::string output;
  FILE *pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return {"it could not be started", -1};
  char part[4096];
  while (const size_t count = fread(part, 1, sizeof part, pipe)) output.append(part, count);
  return {output, pclose(pipe)};
}

// Returns the output of Khronos' compiler for all recorded texts, and its exit status.
std::pair<std::string, int> output_of_validator(const std::string &words) {
  const auto folder = std::filesystem::temp_directory_path() / ("paradesc_texts_" + std::to_string(getpid()));
  write(recording.programs, folder);
  auto said = output_of("cd " + folder.string() + " && glslangValidator " + words + " *.*");
  std::filesystem::remove_all(folder);
  return said;
}

bool has_validator() { return output_of("glslangValidator --version").second == 0; }
constexpr const char *no_validator =
    "glslangValidator is not installed (package glslang-tools), which reads texts more strictly than drivers do";

TEST_F(ShaderTexts, are_taken_by_khronos_own_compiler) {
  if (!has_validator()) GTEST_SKIP() << no_validator;
  send_all();
  const auto [output, status] = output_of_validator("");
  EXPECT_EQ(status, 0);
  EXPECT_EQ(output.find("ERROR"), std::string::npos) << output.substr(0, 4000);
}

TEST_F(ShaderTexts, use_no_more_storage_buffers_and_textures_than_drivers_have) {
  static_assert(BINDING_COUNT <= 16);
  if (!has_validator()) GTEST_SKIP() << no_validator;
  send_all();
  std::istringstream lines(output_of_validator("-E").first); // what is left of each text where its variant is chosen
  size_t texts = 0;
  int buffers = 0, textures = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("#version")) {
      ++texts;
      buffers = textures = 0;
    }
    buffers += line.find(" buffer ") != std::string::npos && line.find("layout") == 0;
    textures += line.find(" uniform ") != std::string::npos && line.find("sampler") != std::string::npos;
    ASSERT_LE(buffers, 16) << line;
    ASSERT_LE(textures, 16) << line;
  }
  EXPECT_GT(texts, 36u);
}

// ---- For other drivers: tests/drivers.sh has every program written to a folder, and each of them makes all of these.

const char *folder_of_texts() { return std::getenv("PARADESC_SHADER_TEXTS"); }

TEST_F(ShaderTexts, are_written_to_a_folder) {
  if (!folder_of_texts()) GTEST_SKIP() << "PARADESC_SHADER_TEXTS names no folder";
  const std::filesystem::path folder = folder_of_texts();
  send_all();
  for (const bool pretended : {false, true}) recording.programs.merge(test::record_plain(pretended));
  write(recording.programs, folder / "sent");
  std::set<Program> possible = test::record_all(true); // whose group size alone differs on a software device
  std::erase_if(possible, [](const Program &program) { return recording.programs.contains(program); });
  write(possible, folder / "possible");
}

TEST(ShaderFolder, of_texts_is_compiled_and_linked_by_this_device) {
  if (!folder_of_texts()) GTEST_SKIP() << "PARADESC_SHADER_TEXTS names no folder";
  std::unique_ptr<GlThread> thread;
  try {
    thread = std::make_unique<GlThread>(false, -1);
  } catch (const Error &) {
    thread = std::make_unique<GlThread>(true, -1);
  }
  std::cout << "device: " << thread->device() << std::endl;
  const std::map<std::string, Program> all = read(folder_of_texts());
  EXPECT_FALSE(all.empty());
  for (const auto &[name, program] : all) {
    std::cerr << "program " << name << std::endl; // before what drivers print about it
    std::vector<ShaderStage> stages;
    std::map<std::string, std::string> texts;
    for (const auto &[stage, text] : program) {
      stages.push_back({stage, name + ending_of(stage)});
      texts[stages.back().path] = text;
    }
    try {
      thread->run([&, &name = name](const Gl &gl, ProgramCache &programs) { programs.get(gl, name, stages, texts); });
    } catch (const Error &error) {
      ADD_FAILURE() << error.what();
    }
  }
  std::cout << all.size() << " programs" << std::endl;
}

} // namespace
} // namespace paradesc
#endif
