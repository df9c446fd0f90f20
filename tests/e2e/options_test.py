# SPDX-License-Identifier: Apache-2.0
"""Two jobs of one program with different options: a change of one job's option reruns that job alone."""

from stub_site import SITE, StubTest
from workspace import BUILD

PROFILE = """
[ceiling_features]
purpose = "finds features of the ceiling"
program = "features"
options = "ceiling_features"
unit = "shard"
in.frames = "frames.shard"
in.cameras = "frames.cameras"
in.data = "data"
out.features = "shard_{unit}.h5"
"""
CEILING = {f"ceiling_features_000{shard}" for shard in range(3)}
NUM_FEATURES = "num_features"


class OptionsTest(StubTest):
    given = ("PROFILE=both",)

    def setUp(self):
        super().setUp()
        self.configs = self.site.folder / "configs"
        (self.configs / "both/default").mkdir(parents=True)
        self.profile = self.configs / "both/pipeline.toml"
        self.profile.write_text(PROFILE)
        self.default = self.configs / "both/default/ceiling_features.toml"
        self.default.write_text((self.configs / "camera/default/features.toml").read_text())

    def ran(self, *arguments):
        """Names of the rules that a run runs, but for the verdict on them."""
        return set(self.site.ran()) - {"verdict"} if "== " in self.make("map", *arguments) else set()

    def test_an_option_reruns_the_job_that_has_it(self):
        self.make("map")
        ceiling = f"SET=ceiling_features.{NUM_FEATURES}=77"
        self.assertRegex(self.make("why", ceiling), rf"ceiling_features_0000: options of ceiling_features changed: {NUM_FEATURES} \d+ -> 77")
        self.assertNotRegex(self.make("why", ceiling), r"(?m)^features_")
        self.assertEqual(self.ran(ceiling), CEILING)
        self.assertIn(f"{NUM_FEATURES} = 77\n", self.site.path("config/ceiling_features.toml").read_text())
        self.assertNotIn(f"{NUM_FEATURES} = 77\n", self.site.path("config/features.toml").read_text())
        self.assertEqual(self.ran(), CEILING)
        ran = self.ran(f"SET=features.{NUM_FEATURES}=77")
        self.assertTrue({"features_0000", "vocabulary"} <= ran and not ran & CEILING, ran)

    def test_files_of_profile_and_site_have_its_name(self):
        (self.configs / "both/ceiling_features.toml").write_text(f"{NUM_FEATURES} = 70\n")
        self.make("map")
        self.assertIn(f"{NUM_FEATURES} = 70\n", self.site.path("config/ceiling_features.toml").read_text())
        (self.configs / f"sites/{SITE}").mkdir(exist_ok=True)
        of_site = self.configs / f"sites/{SITE}/ceiling_features.toml"
        of_site.write_text(f"{NUM_FEATURES} = 71\n")
        self.assertEqual(self.ran(), CEILING)
        of_site.unlink()
        self.assertEqual(self.ran(), CEILING)
        self.assertEqual(self.ran(), set())

    def test_a_job_that_takes_another_file_of_options_runs_again(self):
        self.default.write_text(self.default.read_text().replace(f"{NUM_FEATURES} = ", f"{NUM_FEATURES} = 1"))
        self.make("map")
        self.profile.write_text(PROFILE.replace('options = "ceiling_features"\n', ""))
        self.assertEqual(self.ran(), CEILING)  # config/features.toml is older than its results
        self.assertEqual(self.ran(), set())

    def test_mistakes_name_the_options(self):
        run = self.site.folder / "build/run/features"
        run.unlink()
        run.symlink_to(BUILD / "run/features")
        said = self.make("map", f"SET=ceiling_features.{NUM_FEATURES}=-1", code=2)
        self.assertIn(f"SET: ceiling_features.{NUM_FEATURES} = -1", said)
        self.default.unlink()
        said = self.make("map", code=2)
        self.assertRegex(said, r"configs/both/pipeline.toml:5: \[ceiling_features\]: there is no configs/both/default/ceiling_features.toml: "
                               "copy the default options of features to it")  # fmt: skip
