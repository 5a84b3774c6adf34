#include "proximity_server/scene/files/file_value.h"

#include "scene/files.h"

#include <gtest/gtest.h>

#include <string>

namespace proximity_server::scene::yaml_test {

FileValue read(const std::string& text) { return readYaml(text, "a.yaml"); }
std::string refusal(const std::string& text) {
  return errorOf([&] { read(text); });
}

const FileValue& member(const FileValue& value, const std::string& name) {
  for (const FileValue::Member& member : std::get<FileValue::Map>(value.content))
    if (member.name == name) return member.value;
  throw std::out_of_range(name);
}

template <class T>
T only(const std::string& scalar) {
  return std::get<T>(member(read("a: " + scalar), "a").content);
}

TEST(Yaml, PlainScalarsAreWhatTheyLookLike) {
  EXPECT_EQ(only<double>("12"), 12.0);
  EXPECT_EQ(only<double>("-1.5e-3"), -0.0015);
  EXPECT_EQ(only<double>("+.5"), 0.5);
  EXPECT_EQ(only<bool>("true"), true);
  EXPECT_EQ(only<bool>("False"), false);
  only<std::monostate>("");
  only<std::monostate>("~");
  EXPECT_EQ(only<std::string>("table"), "table");
}

TEST(Yaml, QuotedScalarsAreTexts) {
  EXPECT_EQ(only<std::string>("'12'"), "12");
  EXPECT_EQ(only<std::string>("\"true\""), "true");
  EXPECT_EQ(only<std::string>("\"\""), "");
  EXPECT_EQ(only<std::string>(R"("\u00fc\"")"), "\xc3\xbc\"");
}

TEST(Yaml, WhatIsNoFiniteNumberIsAText) {
  for (const char* text : {".nan", ".inf", "-inf", "nan", "1e999", "0x10", "1 m"})
    EXPECT_EQ(only<std::string>(text), text);
}

TEST(Yaml, EveryValueKnowsItsLine) {
  const FileValue root = read("# a comment\na: 1\nb:\n- 2\n- {c: 3}\n");
  EXPECT_EQ(member(root, "a").line, 2);
  const auto& list = std::get<FileValue::List>(member(root, "b").content);
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0].line, 4);
  EXPECT_EQ(member(list[1], "c").line, 5);
}

TEST(Yaml, NothingIsNull) {
  EXPECT_TRUE(std::holds_alternative<std::monostate>(read("").content));
  EXPECT_TRUE(std::holds_alternative<std::monostate>(read("# nothing\n").content));
}

TEST(Yaml, RefusesWhatIsNoYamlWithItsLine) {
  EXPECT_EQ(refusal("a: 1\nb: [1, 2\n").rfind("a.yaml, line 3: this is no YAML: ", 0), 0U);
  EXPECT_EQ(refusal("a: 1\n b: 2\n").rfind("a.yaml, line 2: this is no YAML: ", 0), 0U);
  EXPECT_NE(refusal(std::string("a: \xff", 4)).find("this is no YAML"), std::string::npos);
  EXPECT_NE(refusal(std::string("a: \0", 4)).find("this is no YAML"), std::string::npos);
}

TEST(Yaml, RefusesWhatItLeavesOut) {
  EXPECT_EQ(refusal("a: &x 1\nb: *x\n"), "a.yaml, line 2: an alias (*name) is not read: write the value out");
  EXPECT_EQ(refusal("a: !!str 1\n"), "a.yaml, line 1: a tag (!name) is not read");
  EXPECT_EQ(refusal("a: 1\n---\nb: 1\n"), "a.yaml, line 2: a second document begins: only one is read");
  EXPECT_EQ(refusal("[1, 2]: 1\n"), "a.yaml, line 1: the name of a field must be a text");
}

TEST(Yaml, RefusesAFieldThatIsThereTwice) {
  EXPECT_EQ(refusal("a: 1\nb: 2\na: 3\n"), "a.yaml, line 3: there are two fields \"a\"");
}

TEST(Yaml, RefusesDeepNesting) {
  EXPECT_EQ(refusal(std::string(100, '[') + std::string(100, ']')), "a.yaml, line 1: it is nested too deep");
  EXPECT_NE(refusal(std::string(1000000, '[')).find("it is nested too deep"), std::string::npos);
}

}  // namespace proximity_server::scene::yaml_test
