from tb.docs.language import forbidden_phrases
from tb.docs.sentences import sample, sentences

SEED = 22


def test_sentences_of_a_page():
    text = ("# Heading\n\nThis is one idea. And this is\nanother one: `x`.\n\n| a | b |\n|---|---|\n\n"
            "* An item of five words\n1. And a second item\n")
    assert sentences(text) == ["This is one idea.", "And this is another one: x.", "An item of five words",
                               "And a second item"]


def test_a_draw_is_repeatable():
    assert sample(SEED) == sample(SEED)
    assert len(sample(SEED)) == 40


def test_no_drawn_sentence_has_a_private_word():
    pattern = forbidden_phrases()
    assert not [(page, sentence) for page, sentence in sample(SEED) if pattern.search(sentence)]
