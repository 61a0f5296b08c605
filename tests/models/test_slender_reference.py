"""Names of one thing in the reference cases of the towed slender body; `test_cradle_reference` computes the cases."""

from towage.verify import slender as verify_slender


def test_corrected_signs_by_either_name() -> None:
    inputs = {"lam": 0.015, "Lam": 1.0, "al": 1.0, "eps": 40.0, "ecf": 1.0}
    one = verify_slender.rigid({**inputs, "published_signs": False}, {})
    other = verify_slender.rigid({**inputs, "theory": "corrected"}, {})
    assert one == other
    assert one != verify_slender.rigid(inputs, {})
