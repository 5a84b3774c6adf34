#include "proximity_server/scene/files/xml_declarations.h"

#include <gtest/gtest.h>

namespace proximity_server::scene::xml_declarations_test {

TEST(XmlDeclarations, OnlyTheFirstOfATextStays) {
  EXPECT_EQ(withoutLateDeclarations(""), "");
  EXPECT_EQ(withoutLateDeclarations("<?xml?><a/>"), "<?xml?><a/>");
  EXPECT_EQ(withoutLateDeclarations("<!-- b -->\n<?xml?><a/>"), "<!-- b -->\n       <a/>");
  EXPECT_EQ(withoutLateDeclarations("<?xml?><?b?><a/><?c?>"), "<?xml?>     <a/>     ");
  EXPECT_EQ(withoutLateDeclarations("<a/><?b\nc?>d"), "<a/>   \n   d") << "lines stay";
  EXPECT_EQ(withoutLateDeclarations("<a/><?b>"), "<a/><?b>") << "the parser refuses it";
}

TEST(XmlDeclarations, CommentsAndCdataHaveNone) {
  for (const char* text : {"<!-- <? --><a/><!-- ?> -->", "<a><![CDATA[<?]]><b/><![CDATA[?>]]></a>"})
    EXPECT_EQ(withoutLateDeclarations(text), text) << "what stands between them stays";
}

}  // namespace proximity_server::scene::xml_declarations_test
