//! Structures by name: their options, and the registry that finds them.

use umbrage::rays::{Bvh, Choice as _, SimdLevel};
use umbrage::{
    Error, KindOption, OptionValues, Renderer, Settings, Structure, StructureKind, StructureOption, Structures,
};
use umbrage_papers::{KdRebuild, KdTreeOptions, KdTrees, structures};

/// Some values that an option can have.
fn values(option: &StructureOption) -> Vec<String> {
    match &option.values {
        OptionValues::Names(names) => names().iter().map(|(name, _)| (*name).to_owned()).collect(),
        OptionValues::Whole(range) | OptionValues::WholeOrAuto(range) => {
            // Blocks of rays are multiples of 16.
            vec![range.end().to_string(), 48.min(*range.end()).to_string()]
        }
        OptionValues::Positive => vec!["0.25".to_owned(), "100".to_owned()],
        OptionValues::Rectangle => vec!["auto".to_owned(), "-30:30:-20:20.5".to_owned()],
        OptionValues::Share => vec!["0".to_owned(), "0.3".to_owned(), "1".to_owned()],
        OptionValues::Switch => vec!["true".to_owned(), "false".to_owned()],
    }
}

#[test]
fn every_option_of_every_structure_is_set_read_and_written() {
    for known in structures().iter() {
        assert!(!known.about().is_empty() && !known.about().ends_with('.'), "{known}");
        for option in known.options() {
            assert!(!option.about.ends_with('.') && !option.name.contains([' ', ':', ',', '=']), "{}", option.name);
            for value in values(option) {
                let mut structure = known.clone();
                if option.name == "tracing-tiles" {
                    structure.set_option("sorting-tile", "8").unwrap();
                }
                structure.set_option(option.name, &value).unwrap();
                assert_eq!(structure.option(option.name), Some(value));
                assert_eq!(structures().parse(&structure.to_string()), Ok(structure));
            }
        }
    }
}

#[test]
fn names_stay_and_need_no_options() {
    let named: Vec<String> = structures().iter().map(ToString::to_string).collect();
    assert_eq!(named, ["perspective", "bvh", "listed", "grid", "kdtree"]);
    let tuned = structures().parse("kdtree:lazy=64").unwrap();
    assert_eq!(tuned.to_string(), "kdtree:lazy=64");
    assert!(named.iter().all(|name| structures().parse(name).unwrap() == structures().named(name).unwrap()));
}

#[test]
fn options_that_exclude_each_other_or_lack_sense_are_refused_in_words() {
    for (text, why) in [
        ("tree", "there is no structure `tree`: did you mean `kdtree`?"),
        ("bvh:packet=4", "it has no options"),
        ("grid:packet=7", "choose one of 2, 4, 8, 16, 32"),
        ("grid:density=0", "a number above 0"),
        ("grid:nested=0", "`auto` or a whole number from 1 on"),
        ("listed:sorting-tile=7", "choose one of 8, 16, 32, 64"),
        ("listed:sorting-tile=16,tracing-tiles=8", "64"),
        ("listed:slices=65", "from 1 to 64"),
        ("listed:light-clamp=10:-10:0:20", "from -180 to 180, as -30:30:-20:20"),
        ("listed:light-clamp=0:10:0", "as -30:30:-20:20"),
        ("listed:whole-tiles=", "`true` or `false`"),
        ("kdtree:builder=fast", "choose one of naive"),
        ("kdtree:bilder=binned", "did you mean `builder`?"),
        ("kdtree:kd-builder=binned", "choose one of builder"),
        ("kdtree:traversal=short-stack:49", "1 to 48"),
        ("kdtree:rebuild=never", "choose one of whole, hierarchy, background"),
        ("kdtree:lazy=4097", "from 0 to 4096"),
        ("kdtree:packet=5", "choose one of 4, 8, 16"),
        ("kdtree:test-cost=0", "a number above 0"),
        ("kdtree:empty-cost=1.5", "a number from 0 to 1"),
        ("kdtree:empty-cost=NaN", "a number from 0 to 1"),
        ("kdtree:charge-twice=no", "`true` or `false`"),
    ] {
        let refused = structures().parse(text).unwrap_err().to_string();
        assert!(refused.contains(why), "{text}: {refused}");
    }
}

#[test]
fn larger_tiles_leave_room_for_fewer() {
    let mut listed = structures().named("listed").unwrap();
    listed.set_option("sorting-tile", "64").unwrap();
    assert_eq!(listed.option("tracing-tiles").as_deref(), Some("1"));
    let before = listed.clone();
    listed.set_option("tracing-tiles", "2").unwrap_err();
    assert!(listed == before);
}

#[test]
fn gpus_have_some_structures_and_options() {
    let refused = |text: &str| {
        let structure: Structure = structures().parse(text).unwrap();
        structure.check_on_gpu().map_err(|error| error.to_string())
    };
    for text in ["perspective", "listed", "listed:sorting-tile=8,slices=3,light-map=spherical", "kdtree:packet=8"] {
        assert_eq!(refused(text), Ok(()), "{text}");
    }
    for (text, why) in [
        ("bvh", "but not `bvh`"),
        ("grid", "but not `grid`"),
        ("listed:light-rays=16", "no option `light-rays`"),
        ("listed:sorting-tile=32", "8 or 16"),
        ("listed:tracing-tiles=2", "16 pixels a side"),
        ("kdtree:lazy=9", "no option `lazy`"),
        ("kdtree:rebuild=fuzzy", "no option `rebuild`"),
    ] {
        assert!(refused(text).unwrap_err().contains(why), "{text}");
    }
}

#[test]
fn trees_that_outlive_a_frame_are_not_lazy() {
    let scene = umbrage::open("demo:cloth?triangles=50").unwrap();
    for &(name, rebuild, _) in KdRebuild::CHOICES {
        let render = |lazy_below| {
            let options = KdTreeOptions { lazy_below, ..KdTreeOptions::FAST };
            let structure = Structure::new(KdTrees { options, rebuild });
            let settings = Settings { width: 8, height: 8, structure, ..Settings::default() };
            Renderer::default().render(&scene, 0.0, &settings).map(drop)
        };
        render(0).unwrap();
        let is_built_anew = matches!(rebuild, KdRebuild::Whole | KdRebuild::Hierarchy);
        match render(64) {
            Ok(()) => assert!(is_built_anew, "{name}"),
            Err(refused) => {
                assert!(!is_built_anew && refused.is_of_settings(), "{name}");
                assert!(refused.to_string().contains("no option `lazy`"), "{refused}");
            }
        }
    }
}

#[test]
fn four_samples_at_once_show_the_same_through_every_structure() {
    let scene = umbrage::open("demo:forest?triangles=3000").unwrap();
    let render = |structure: &Structure| {
        let structure = structure.clone();
        // More than one tile along each axis, none of them whole.
        let settings = Settings { width: 70, height: 67, samples: 4, structure, bounces: 1, ..Settings::default() };
        let mut renderer = Renderer::default();
        let film = renderer.render(&scene, 0.4, &settings).unwrap();
        (film.triangle.clone(), film.color.clone())
    };
    let expected = render(&Structure::default());
    for structure in structures().iter() {
        assert!(render(structure) == expected, "{structure}");
    }
}

/// A hierarchy with two options.
#[derive(Clone, Debug, Default, PartialEq)]
struct Tuned {
    depth: u32,
    is_wide: bool,
}

impl StructureKind for Tuned {
    const NAME: &'static str = "tuned";
    const ABOUT: &'static str = "a hierarchy with options";
    const OPTIONS: &'static [KindOption<Self>] = &[
        KindOption {
            option: StructureOption {
                name: "depth",
                about: "Levels",
                values: OptionValues::Whole(0..=9),
                is_on_gpu: false,
            },
            get: |tuned| tuned.depth.to_string(),
            set: |tuned, value| {
                tuned.depth = value.parse().map_err(|_| "no number".to_owned())?;
                if tuned.depth == 7 { Err("7 levels are too many".to_owned()) } else { Ok(()) }
            },
        },
        KindOption {
            option: StructureOption {
                name: "wide",
                about: "Wide nodes",
                values: OptionValues::Switch,
                is_on_gpu: false,
            },
            get: |tuned| tuned.is_wide.to_string(),
            set: |tuned, value| {
                tuned.is_wide = value == "true";
                Ok(())
            },
        },
    ];

    fn make(&self, level: SimdLevel, _: bool) -> Result<Box<dyn umbrage::rays::Structure>, Error> {
        Ok(Box::new(Bvh::with_level(level)))
    }
}

#[test]
fn registered_structures_are_found_by_name_and_written_with_their_options() {
    let structures = Structures::default().with::<Tuned>().with::<Tuned>();
    let names: Vec<_> = structures.iter().map(Structure::name).collect();
    assert_eq!(names, ["perspective", "bvh", "tuned"]);
    for text in ["perspective", "bvh", "tuned", "tuned:depth=3", "tuned:depth=3,wide=true"] {
        assert_eq!(structures.parse(text).unwrap().to_string(), text);
    }
    let tuned = Structure::new(Tuned { depth: 3, is_wide: true });
    assert_eq!(structures.parse("tuned:wide,depth=3").unwrap(), tuned);
    assert_eq!(tuned.kind(), Some(&Tuned { depth: 3, is_wide: true }));
    assert_ne!(tuned, Structure::of::<Tuned>());
    assert_ne!(Structure::default(), Structure::bvh());
    assert_eq!(structures.only(Structure::is_specialised).iter().len(), 1);
    assert!(tuned.check_on_gpu().is_err());
}

#[test]
fn refused_texts_name_the_nearest_right_ones() {
    let structures = Structures::default().with::<Tuned>();
    for (text, why) in [
        ("tuend", "there is no structure `tuend`: did you mean `tuned`? choose one of perspective, bvh, tuned"),
        ("xyz", "there is no structure `xyz`: choose one of perspective, bvh, tuned"),
        ("bvh:depth=4", "bvh:depth=4: it has no options"),
        ("tuned:deph=4", "tuned:deph=4: did you mean `depth`? choose one of depth, wide"),
        ("tuned:depth=10", "tuned:depth=10: give a whole number from 0 to 9"),
        ("tuned:depth=7", "tuned:depth=7: 7 levels are too many"),
        ("tuned:wide=no", "tuned:wide=no: give `true` or `false`"),
    ] {
        assert_eq!(structures.parse(text).unwrap_err().to_string(), why);
    }
    let mut tuned = Structure::of::<Tuned>();
    tuned.set_option("depth", "7").unwrap_err();
    assert_eq!(tuned, Structure::of::<Tuned>(), "nothing is changed");
}
