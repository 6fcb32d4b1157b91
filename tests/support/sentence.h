// How an error or a warning must read.
#pragma once

#include <cctype>
#include <string>

#include <gtest/gtest.h>

namespace paradesc::test {

// There is one on one line, and no second begins.
inline void expect_one_sentence(const std::string &text) {
  EXPECT_FALSE(text.empty());
  EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  for (size_t dot = text.find(". "); dot != std::string::npos; dot = text.find(". ", dot + 1))
    EXPECT_FALSE(dot + 2 < text.size() && std::isupper(static_cast<unsigned char>(text[dot + 2]))) << "two sentences: " << text;
}

// And it says this.
inline void expect_one_sentence(const std::string &text, const std::string &word) {
  EXPECT_NE(text.find(word), std::string::npos) << "no \"" << word << "\" in: " << text;
  expect_one_sentence(text);
}

} // namespace paradesc::test
