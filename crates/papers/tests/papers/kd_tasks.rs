use umbrage_papers::kd_tasks::{Tasks, tasks};
use umbrage_papers::{KdBuilder, KdTree, KdTreeOptions};
use umbrage_rays::Triangles;

#[test]
fn threads_wait_for_what_comes_before() {
    let mut tasks = Tasks::default();
    let first = tasks.add(3, &[]);
    let left = tasks.add(4, &[first]);
    let right = tasks.add(5, &[first]);
    tasks.add(1, &[left]);
    tasks.add(2, &[left, right]);
    assert_eq!(tasks.total(), 15);
    assert_eq!(tasks.simulated(1), 15);
    // 3, then 4 and 1 beside 5, then 2; more threads stay idle.
    assert_eq!([2, 3, 16].map(|threads| tasks.simulated(threads)), [10; 3]);
    assert_eq!(Tasks::default().simulated(4), 0);
}

#[test]
fn builds_of_a_tree_are_the_same_work() {
    let corner = |id: u32, step: u32| [7.3, 3.1, 5.7].map(|factor| ((id * 3 + step) as f32 * factor).sin() * 0.02);
    let middle = |id: u32| [1.7, 2.9, 4.3].map(|factor| (id as f32 * factor).sin());
    let point = |id: u32, step: u32| glam::Vec3::from_array(corner(id, step)) + glam::Vec3::from_array(middle(id));
    let positions: Vec<_> = (0..40_000).flat_map(|id| [0, 1, 2].map(|step| point(id, step))).collect();
    let indices: Vec<_> = (0..40_000).map(|id| [0, 1, 2].map(|step| id * 3 + step)).collect();
    let mut tree = KdTree::default();
    tree.set_options(KdTreeOptions::FAST).unwrap();
    tree.build(Triangles { positions: &positions, indices: &indices });
    let builders = [KdBuilder::Presorted, KdBuilder::Binned, KdBuilder::Nested, KdBuilder::InPlace];
    let [alone, others @ ..] = builders.map(|builder| tasks(&tree, builder));
    // The root's pass is one task, unless threads share it.
    assert!(alone.simulated(1000) >= 40_000);
    for tasks in others {
        assert_eq!(tasks.total(), alone.total());
        assert_eq!(tasks.simulated(1), tasks.total());
        for threads in [2, 4, 16] {
            let time = tasks.simulated(threads);
            assert!(time < alone.simulated(threads) && time >= tasks.total() / threads as u64, "{time}");
        }
    }
}
